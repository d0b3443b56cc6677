//! Strips of triangles.

/// Appends the triangles of a strip: corners k, k + 1, k + 2, every second one turned over so that all face one way.
pub(super) fn push_strip(faces: &mut Vec<[u32; 3]>, strip: &[u32]) {
    for (k, corners) in strip.windows(3).enumerate() {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        faces.push(if k % 2 == 0 { [a, b, c] } else { [a, c, b] });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_a_strip_agree() {
        let mut faces = Vec::new();
        push_strip(&mut faces, &[0, 1, 2, 3, 4]);
        push_strip(&mut faces, &[5, 6]);
        assert_eq!(faces, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    }
}
