//! What the three writers make of marks whose dots and bytes are known.

use super::*;

fn sample() -> Drawing {
    let mut drawing = Drawing::new([40.0, 30.0], "a <title> & more");
    let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
    // A frame: what lies within both rings is not of it.
    drawing.area(vec![square(2.0, 22.0), square(6.0, 18.0)], [200, 0, 0], 1.0);
    drawing.area(vec![square(8.0, 16.0)], [0, 0, 200], 0.5);
    drawing.line(vec![[0.0, 28.0], [40.0, 28.0]], 1.0, [0, 100, 0]);
    drawing.text([30.0, 20.0], 4.0, Anchor::Middle, "I \"<&");
    drawing
}

#[test]
fn dots_are_where_the_marks_are() {
    let picture = Picture::of(&sample());
    assert_eq!((picture.width, picture.height), (80, 60));
    let at = |x: f64, y: f64| picture.pixels[(y * 2.0) as usize * 80 + (x * 2.0) as usize];
    assert_eq!(at(4.0, 12.0), [200, 0, 0]);
    assert_eq!(at(7.0, 7.0), [255, 255, 255], "the hole");
    assert_eq!(at(12.0, 12.0), [128, 128, 228], "half of blue on white");
    assert_eq!(at(20.0, 28.0), [0, 100, 0]);
    assert_eq!(at(1.0, 1.0), [255, 255, 255]);
    // The frame's area, dot by dot: 20 x 20 less 12 x 12 units of four dots.
    let red = picture.pixels.iter().filter(|p| **p == [200, 0, 0]).count();
    assert_eq!(red, (400 - 144) * 4);
}

#[test]
fn an_edge_aslant_covers_half_of_its_dots() {
    let mut drawing = Drawing::new([20.0, 20.0], "");
    drawing.area(vec![vec![[0.0, 0.0], [20.0, 20.0], [0.0, 20.0]]], [0, 0, 0], 1.0);
    let picture = Picture::of(&drawing);
    let dark: f64 = picture.pixels.iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum();
    assert!((dark - 800.0).abs() < 2.0, "{dark} dots for 40 * 40 / 2");
    assert!((0..40).all(|i| (100..156).contains(&picture.pixels[i * 40 + i][0])));
}

#[test]
fn a_png_reads_back_as_the_picture() {
    let drawing = sample();
    let (bytes, picture) = (drawing.bytes(Format::Png), Picture::of(&drawing));
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut read = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut read).unwrap();
    assert_eq!((info.width as usize, info.height as usize), (picture.width, picture.height));
    assert_eq!(read, picture.pixels.concat());
}

#[test]
fn words_do_no_harm_in_an_svg() {
    let text = String::from_utf8(sample().bytes(Format::Svg)).unwrap();
    assert!(text.contains("<title>a &lt;title&gt; &amp; more</title>") && text.contains(">I &quot;&lt;&amp;<"));
    assert!(text.contains("M2 2l20 0 0 20 -20 0zM6 6l12 0 0 12 -12 0z") && text.contains("fill-rule=\"evenodd\""));
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut depth = 0;
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Start(_) => depth += 1,
            quick_xml::events::Event::End(_) => depth -= 1,
            quick_xml::events::Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(depth, 0);
}

#[test]
fn every_object_of_a_pdf_is_where_its_table_says() {
    let bytes = sample().bytes(Format::Pdf);
    let text: String = bytes.iter().map(|b| char::from(*b)).collect();
    let start: usize = text.rsplit("startxref\n").next().unwrap().lines().next().unwrap().parse().unwrap();
    let mut table = text[text.char_indices().nth(start).unwrap().0..].lines();
    assert_eq!(table.next(), Some("xref"));
    let count: usize = table.next().unwrap().strip_prefix("0 ").unwrap().parse().unwrap();
    for number in 1..count {
        let place: usize = table.clone().nth(number).unwrap()[..10].parse().unwrap();
        assert!(bytes[place..].starts_with(format!("{number} 0 obj\n").as_bytes()), "object {number}");
    }
    assert!(text.contains("/MediaBox [0 0 30.00 22.50]"));
    let from = text.find("stream\n").unwrap() + 7;
    let from = text[..from].chars().count();
    let mut page = String::new();
    std::io::Read::read_to_string(&mut flate2::read::ZlibDecoder::new(&bytes[from..]), &mut page).unwrap();
    // y counts upward in a PDF.
    assert!(page.contains("2.00 28.00 m 22.00 28.00 l") && page.contains("<4920223c26> Tj"), "{page}");
}
