//! The plot: what is left of the squared curvature over the largest distance, both by powers of ten.

use super::Entry;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
const COLOURS: [(&str, &str); 5] = [
    ("plain", "#888888"),
    ("stencil", "#c9a227"),
    ("tether", "#d1495b"),
    ("lift", "#6a4c93"),
    ("conformal", "#00798c"),
];
/// Powers of ten that are shown.
const DISTANCES: [i32; 2] = [-1, 1];
const SQUARES: [i32; 2] = [-6, 1];

pub(crate) fn svg(entries: &[Entry]) -> String {
    let mut lines = vec![
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">"##
        ),
        r##"<rect width="100%" height="100%" fill="#ffffff"/>"##.to_owned(),
    ];
    for power in DISTANCES[0]..=DISTANCES[1] {
        let at = x(10_f64.powi(power));
        lines.push(format!(r##"<line x1="{at:.1}" x2="{at:.1}" y1="30" y2="{}" stroke="#ddd"/>"##, HEIGHT - 40.0));
        lines.push(format!(
            r##"<text x="{at:.1}" y="{}" text-anchor="middle" fill="#666">{}</text>"##,
            HEIGHT - 24.0,
            10_f64.powi(power)
        ));
    }
    for power in SQUARES[0]..=SQUARES[1] {
        let at = y(10_f64.powi(power));
        lines.push(format!(r##"<line x1="60" x2="{}" y1="{at:.1}" y2="{at:.1}" stroke="#ddd"/>"##, WIDTH - 20.0));
        lines.push(format!(r##"<text x="54" y="{:.1}" text-anchor="end" fill="#666">1e{power}</text>"##, at + 4.0));
    }
    lines.push(format!(
        r##"<text x="{}" y="{}" text-anchor="middle">largest distance from what was drawn, mean edges</text>"##,
        0.5 * WIDTH,
        HEIGHT - 6.0
    ));
    lines.push(r##"<text x="60" y="18">squared curvature left</text>"##.to_owned());
    for (row, (mode, colour)) in COLOURS.iter().enumerate() {
        let own: Vec<&Entry> =
            entries.iter().filter(|e| e.mode == *mode && e.square > 0.0 && e.distance > 0.0).collect();
        let points: Vec<String> = own.iter().map(|e| format!("{:.1},{:.1}", x(e.distance), y(e.square))).collect();
        lines.push(format!(
            r##"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.5"/>"##,
            points.join(" ")
        ));
        for entry in own {
            let [cx, cy] = [x(entry.distance), y(entry.square)];
            lines.push(format!(r##"<circle cx="{cx:.1}" cy="{cy:.1}" r="3.5" fill="{colour}"/>"##));
            lines.push(format!(
                r##"<text x="{:.1}" y="{:.1}" fill="{colour}" font-size="10">{}</text>"##,
                cx + 6.0,
                cy - 4.0,
                entry.setting
            ));
        }
        let at = 250.0 + 100.0 * row as f64;
        lines.push(format!(r##"<text x="{at}" y="18" fill="{colour}">{mode}</text>"##));
    }
    lines.push("</svg>\n".to_owned());
    lines.join("\n")
}

fn share(value: f64, [low, high]: [i32; 2]) -> f64 {
    let (low, high) = (f64::from(low), f64::from(high));
    ((value.log10() - low) / (high - low)).clamp(0.0, 1.0)
}

fn x(distance: f64) -> f64 {
    60.0 + share(distance, DISTANCES) * (WIDTH - 80.0)
}

fn y(square: f64) -> f64 {
    HEIGHT - 40.0 - share(square, SQUARES) * (HEIGHT - 70.0)
}
