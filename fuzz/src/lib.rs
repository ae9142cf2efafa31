//! Requirements of the targets on every list of problems.

use linewright_diagnostics::Problems;
use miette::{GraphicalReportHandler, GraphicalTheme};

/// Problems of a description, which is kept whole: they can be drawn, and point into the text.
pub fn draw_description(text: &str, problems: &Problems) {
    for problem in problems.iter() {
        assert!(text.get(problem.span.clone()).is_some(), "{problem} points out of the text");
        assert!(problem.line >= 1 && problem.column >= 1);
        assert!(problem.line <= text.lines().count().max(1) + 1, "{problem} is behind the last line");
        for (span, _) in &problem.also {
            assert!(text.get(span.clone()).is_some(), "{problem} also points out of the text");
        }
    }
    drawn(problems);
}

/// Problems of a foreign file, which is kept in excerpts: they can be drawn in at most `drawn_max` bytes, and point into
/// the file.
pub fn draw_foreign(bytes: &[u8], problems: &Problems, drawn_max: usize) {
    let lines = bytes.iter().filter(|&&byte| byte == b'\n').count() + 1;
    for problem in problems.iter() {
        assert!((1..=lines).contains(&problem.line) && problem.column >= 1, "{problem}");
        assert!(problem.message.len() < 1000, "{problem}");
        // ISO-8859-1 becomes longer as text, twice at most.
        assert!(problem.span.start <= problem.span.end && problem.span.end <= 2 * bytes.len(), "{problem}");
    }
    let drawn = drawn(problems);
    assert!(drawn.len() < drawn_max, "a drawing of {} bytes", drawn.len());
}

fn drawn(problems: &Problems) -> String {
    let mut drawn = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .render_report(&mut drawn, problems)
        .expect("every report can be drawn");
    drawn
}
