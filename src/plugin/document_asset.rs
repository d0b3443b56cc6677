//! Documents as assets of the engine: loader and saver.

use std::io;
use std::path::PathBuf;

use bevy::asset::io::{Reader, Writer};
use bevy::asset::saver::{AssetSaver, SavedAsset};
use bevy::asset::{AssetLoader, AssetPath, AsyncWriteExt, LoadContext};
use bevy::prelude::*;

use crate::format::document::{Document, DocumentError};

/// A [`Document`] as an asset, in files that end in `.splines.ron`.
#[derive(Asset, TypePath, Clone, Debug, PartialEq, Deref)]
pub struct DocumentAsset(pub Document);

/// Loads [`DocumentAsset`]s.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct DocumentLoader;

/// Writes [`DocumentAsset`]s where the engine wants them written, as its asset processor does.
///
/// It writes into the file that is there. A program that saves what somebody made uses
/// [`SaveDocument`](super::SaveDocument) or [`Document::save`], which leave a whole file whatever happens.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct DocumentSaver;

fn failed(path: PathBuf) -> impl FnOnce(io::Error) -> DocumentError {
    move |source| DocumentError::Io { path, source }
}

impl AssetLoader for DocumentLoader {
    type Asset = DocumentAsset;
    type Settings = ();
    type Error = DocumentError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &Self::Settings,
        context: &mut LoadContext<'_>,
    ) -> Result<DocumentAsset, DocumentError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await.map_err(failed(context.path().path().to_owned()))?;
        Document::from_bytes(&bytes).map(DocumentAsset)
    }

    fn extensions(&self) -> &[&str] {
        &[Document::EXTENSION]
    }
}

impl AssetSaver for DocumentSaver {
    type Asset = DocumentAsset;
    type Settings = ();
    type OutputLoader = DocumentLoader;
    type Error = DocumentError;

    async fn save(
        &self,
        writer: &mut Writer,
        asset: SavedAsset<'_, '_, DocumentAsset>,
        (): &Self::Settings,
        path: AssetPath<'_>,
    ) -> Result<(), DocumentError> {
        let text = asset.to_ron()?;
        writer.write_all(text.as_bytes()).await.map_err(failed(path.path().to_owned()))
    }
}
