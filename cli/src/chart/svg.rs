//! Bar charts as SVG. Callers choose the left margin from the length of the names and an average letter width, because the
//! font of the viewer is unknown.

use std::fmt::Write as _;

use super::{ActivityBar, BarChart, TimeSpan};

/// Fill of planned bars.
pub const PLANNED: &str = "#b8c4d0";

/// Dimensions (in SVG user units) and colours of a chart.
pub struct SvgStyle {
    /// Content of `<defs>`: patterns and markers.
    pub defs: &'static str,
    /// Width of the time axis.
    pub width: f64,
    /// Height of a row.
    pub row: f64,
    /// Distance of the first row from the upper edge.
    pub top: f64,
    /// Distance of the last row from the lower edge.
    pub bottom: f64,
    /// Distance of the grid lines' ends from the lower edge.
    pub grid: f64,
    pub times: TimeLabels,
    /// Baseline of names, from the top of the row.
    pub baseline: f64,
    /// Planned bar: distance from the top of the row, and height.
    pub plan: (f64, f64),
    /// Actual bar: distance from the top of the row, and height.
    pub done: (f64, f64),
    /// Fill of the failed stretch of a bar.
    pub failed: &'static str,
    /// Attributes of every bar.
    pub outline: &'static str,
    /// Text before the times in the tool tip of a planned bar.
    pub planned: &'static str,
}

/// A chart with a row for each operation: planned bars in the upper half of a row, actual ones in the lower.
pub const BY_OPERATION: SvgStyle = SvgStyle {
    defs: "",
    width: 720.0,
    row: 26.0,
    top: 64.0,
    bottom: 20.0,
    grid: 16.0,
    times: TimeLabels::Above,
    baseline: 17.0,
    plan: (4.0, 9.0),
    done: (13.0, 9.0),
    failed: "none",
    outline: "",
    planned: "",
};
/// Average width of a letter of [`BY_OPERATION`], in plain and in bold type.
pub const LETTER: f64 = 6.8;
pub const BOLD: f64 = 8.0;

/// Position of the times.
pub enum TimeLabels {
    Above,
    Below,
}

/// SVG text under construction.
pub struct SvgChart<'a> {
    text: String,
    chart: &'a BarChart,
    style: &'a SvgStyle,
    labels: f64,
    height: f64,
}

impl<'a> SvgChart<'a> {
    /// The title and an empty sheet; `labels` is the width of the names' margin.
    pub fn new(chart: &'a BarChart, style: &'a SvgStyle, labels: f64, title: &str) -> Self {
        let width = labels + style.width + 28.0;
        let height = style.top + style.row * chart.rows.len() as f64 + style.bottom;
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
             font-size=\"12\">\n\
             <defs>{}</defs>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n\
             <text x=\"8\" y=\"20\" font-size=\"15\">{}</text>\n",
            style.defs,
            escaped(title)
        );
        SvgChart { text, chart, style, labels, height }
    }

    /// Position of a time.
    pub fn x(&self, at: f64) -> f64 {
        self.labels + at / self.chart.span * self.style.width
    }

    /// Upper edge of a row.
    pub fn y(&self, row: usize) -> f64 {
        self.style.top + self.style.row * row as f64
    }

    /// The finished SVG document.
    pub fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    pub fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
    }

    /// Draws grid lines at round times (at most 12), row names and bars.
    pub fn rows(&mut self) {
        let bottom = self.height - self.style.grid;
        let written = match self.style.times {
            TimeLabels::Above => self.style.top - 8.0,
            TimeLabels::Below => self.height - 6.0,
        };
        for at in steps(self.chart.span) {
            let (x, top) = (self.x(at), self.style.top - 4.0);
            self.line(format_args!(
                "<line x1=\"{x:.1}\" y1=\"{top:.1}\" x2=\"{x:.1}\" y2=\"{bottom:.1}\" stroke=\"#ddd\"/>\
                 <text x=\"{x:.1}\" y=\"{written:.1}\" text-anchor=\"middle\" fill=\"#777\">{at} s</text>"
            ));
        }
        let chart = self.chart;
        for (number, row) in chart.rows.iter().enumerate() {
            let y = self.y(number);
            let baseline = y + self.style.baseline;
            if let Some(group) = &row.group {
                let (right, group) = (self.labels + self.style.width, escaped(group));
                self.line(format_args!(
                    "<line x1=\"0\" y1=\"{y:.1}\" x2=\"{right:.1}\" y2=\"{y:.1}\" stroke=\"#999\"/>\
                     <text x=\"8\" y=\"{baseline:.1}\" font-weight=\"bold\">{group}</text>"
                ));
            }
            if !row.name.is_empty() {
                let (right, name) = (self.labels - 8.0, escaped(&row.name));
                self.line(format_args!("<text x=\"{right:.1}\" y=\"{baseline:.1}\" text-anchor=\"end\">{name}</text>"));
            }
            row.bars.iter().for_each(|bar| self.bar(bar, y));
        }
    }

    fn bar(&mut self, bar: &ActivityBar, y: f64) {
        let &SvgStyle { plan, done, failed, planned, .. } = self.style;
        if let Some(span) = bar.planned {
            self.rectangle(bar, span, (y, plan), PLANNED, planned);
        }
        let Some((from, to)) = bar.actual else { return };
        let sound_until = bar.failed.as_ref().map_or(to, |(at, _)| at.max(from));
        self.rectangle(bar, (from, sound_until), (y, done), bar.colour, "");
        if let Some((at, cause)) = &bar.failed {
            self.rectangle(bar, (*at, to), (y, done), failed, &format!("{cause} "));
        }
        let left = self.x(from.max(0.0));
        if let Some(number) = bar.number.filter(|_| self.x(sound_until) - left > 18.0) {
            let (x, y) = (left + 3.0, y + done.0 + 11.0);
            self.line(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"10\" fill=\"white\">{number}</text>"));
        }
    }

    fn rectangle(
        &mut self,
        bar: &ActivityBar,
        (from, to): TimeSpan,
        (y, (top, height)): (f64, TimeSpan),
        fill: &str,
        what: &str,
    ) {
        let (x, y) = (self.x(from.max(0.0)), y + top);
        let (width, outline) = ((self.x(to) - x).max(1.0), self.style.outline);
        let (about, what) = (escaped(&bar.about), escaped(what));
        self.line(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height}\" fill=\"{fill}\"{outline}>\
             <title>{about}{what}{from:.3} – {to:.3} s</title></rect>"
        ));
    }
}

/// Round times, at most a dozen of them, from zero to the end of a span.
pub fn steps(span: f64) -> Vec<f64> {
    let magnitude = 10f64.powf((span / 10.0).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * magnitude).into_iter().find(|step| span / step <= 12.0);
    let step = step.unwrap_or(span);
    let count = (span / step).floor() as u32;
    (0..=count).map(|n| (f64::from(n) * step * 1e6).round() / 1e6).collect()
}

/// Escapes text for element content and attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_few() {
        assert_eq!(steps(3.5), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]);
        assert_eq!(steps(1.0).len(), 11);
        for span in [1e-6, 0.3, 7.118, 59.0, 1e5, 1e9] {
            let steps = steps(span);
            assert!((2..=13).contains(&steps.len()) && steps.iter().all(|&at| at <= span + 1e-6), "{span}: {steps:?}");
        }
    }
}
