//! Counts segments in path data by the grammar of SVG 1.1, section 8.3.9, and by nothing of the crate.

/// Lines, quadratics, cubics, arcs, closings.
pub(super) type Counts = [u64; 5];

/// The segments of path data, which must be legal.
pub(super) fn count(data: &str) -> Counts {
    let bytes = data.as_bytes();
    let mut at = 0;
    let mut counts = [0; 5];
    loop {
        skip(bytes, &mut at, b" \t\r\n\x0c");
        let Some(command) = bytes.get(at) else { return counts };
        at += 1;
        let (numbers, kind) = match command.to_ascii_lowercase() {
            b'm' => (2, None),
            b'l' => (2, Some(0)),
            b'h' | b'v' => (1, Some(0)),
            b'q' => (4, Some(1)),
            b't' => (2, Some(1)),
            b'c' => (6, Some(2)),
            b's' => (4, Some(2)),
            b'a' => (7, Some(3)),
            b'z' => {
                counts[4] += 1;
                continue;
            }
            other => panic!("`{}` at byte {} is no command", char::from(other), at - 1),
        };
        let mut times = 0;
        while times == 0 || begins_number(bytes, at) {
            for k in 0..numbers {
                let flag = numbers == 7 && (k == 3 || k == 4);
                if flag { read_flag(bytes, &mut at) } else { read_number(bytes, &mut at) }
            }
            times += 1;
        }
        match kind {
            Some(kind) => counts[kind] += times,
            None => counts[0] += times - 1, // further pairs after a moveto are lines
        }
    }
}

/// The numbers of a list.
pub(super) fn numbers(text: &str) -> Vec<f64> {
    let (bytes, mut at, mut found) = (text.as_bytes(), 0, Vec::new());
    while begins_number(bytes, at) {
        skip(bytes, &mut at, b" \t\r\n\x0c,");
        let begin = at;
        read_number(bytes, &mut at);
        found.push(text[begin..at].trim_matches([' ', ',', '\n', '\t', '\r']).parse().expect("a number"));
    }
    found
}

fn skip(bytes: &[u8], at: &mut usize, what: &[u8]) {
    while bytes.get(*at).is_some_and(|b| what.contains(b)) {
        *at += 1;
    }
}

/// Whether a number comes next, behind white space and a comma.
fn begins_number(bytes: &[u8], mut at: usize) -> bool {
    skip(bytes, &mut at, b" \t\r\n\x0c,");
    bytes.get(at).is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b))
}

fn read_flag(bytes: &[u8], at: &mut usize) {
    skip(bytes, at, b" \t\r\n\x0c,");
    assert!(matches!(bytes.get(*at), Some(b'0' | b'1')), "no flag at byte {at}");
    *at += 1;
}

fn read_number(bytes: &[u8], at: &mut usize) {
    skip(bytes, at, b" \t\r\n\x0c,");
    let begin = *at;
    if matches!(bytes.get(*at), Some(b'+' | b'-')) {
        *at += 1;
    }
    let digits = |at: &mut usize| {
        let begin = *at;
        skip(bytes, at, b"0123456789");
        *at - begin
    };
    let mut count = digits(at);
    if bytes.get(*at) == Some(&b'.') {
        *at += 1;
        count += digits(at);
    }
    assert!(count > 0, "no number at byte {begin}");
    if matches!(bytes.get(*at), Some(b'e' | b'E')) {
        *at += 1;
        if matches!(bytes.get(*at), Some(b'+' | b'-')) {
            *at += 1;
        }
        assert!(digits(at) > 0, "no exponent at byte {at}");
    }
}

#[test]
fn the_tokenizer_counts() {
    assert_eq!(count("M1 2 3 4-5-6z m.5.5.5.5"), [3, 0, 0, 0, 1]);
    assert_eq!(count("M0,0H1 2V3C1 1 2 2 3 3s1 1 2 2 3 3 4 4q1 1 2 2t1 1 2 2Z"), [3, 3, 3, 0, 1]);
    assert_eq!(count("M0 0a1 1 0 1110 10 1 1 0 0 0-1e-3.5"), [0, 0, 0, 2, 0]);
    assert_eq!(numbers(" 1,2 -3.5.25e1\n4 "), [1.0, 2.0, -3.5, 2.5, 4.0]);
}
