//! Two kinds of plots, as SVG that reads on light and dark pages.

use crate::number;

const STYLE: &str = "<style>text{font:13px system-ui,sans-serif;fill:#444}.t{font-weight:600;\
    font-size:15px}.o{fill:#d9480f}.p{fill:#868e96}.g{stroke:#ced4da;stroke-width:1}\
    .l{fill:none;stroke-width:2}@media(prefers-color-scheme:dark){text{fill:#ddd}\
    .g{stroke:#495057}}</style>";

/// Bars, one under the other; ours stand out.
pub struct Bars {
    title: String,
    rows: Vec<(String, f64, bool)>,
}

impl Bars {
    /// With a title that names the unit.
    pub fn new(title: &str) -> Self {
        Self { title: title.into(), rows: Vec::new() }
    }

    /// Appends a bar.
    pub fn bar(&mut self, name: &str, value: f64) {
        self.rows.push((name.into(), value, name.starts_with("lafet")));
    }

    /// The picture.
    pub fn svg(&self) -> String {
        const LEFT: f64 = 230.0;
        const WIDE: f64 = 380.0;
        const STEP: f64 = 24.0;
        let height = 44.0 + STEP * self.rows.len() as f64;
        let most = self.rows.iter().map(|row| row.1).fold(f64::MIN_POSITIVE, f64::max);
        let mut body = String::new();
        for (index, (name, value, ours)) in self.rows.iter().enumerate() {
            let y = 36.0 + STEP * index as f64;
            let (width, class) = (value / most * WIDE, if *ours { "o" } else { "p" });
            body += &format!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text><rect class=\"{class}\" \
                 x=\"{LEFT}\" y=\"{y}\" width=\"{width:.1}\" height=\"16\"/><text x=\"{:.1}\" \
                 y=\"{}\">{}</text>\n",
                LEFT - 8.0,
                y + 13.0,
                LEFT + width + 6.0,
                y + 13.0,
                number(*value),
            );
        }
        picture(700.0, height, &self.title, &body)
    }
}

/// Lines over a logarithmic axis.
pub struct Lines {
    title: String,
    lines: Vec<(String, Vec<(f64, f64)>)>,
}

impl Lines {
    /// With a title that names both axes.
    pub fn new(title: &str) -> Self {
        Self { title: title.into(), lines: Vec::new() }
    }

    /// Appends a line.
    pub fn line(&mut self, name: &str, points: Vec<(f64, f64)>) {
        self.lines.push((name.into(), points));
    }

    /// The picture.
    pub fn svg(&self) -> String {
        const COLOURS: [&str; 4] = ["#d9480f", "#1971c2", "#2f9e44", "#868e96"];
        let all = || self.lines.iter().flat_map(|line| &line.1);
        let most = all().map(|point| point.1).fold(f64::MIN_POSITIVE, f64::max) * 1.1;
        let last = all().map(|point| point.0.log10()).fold(1.0, f64::max);
        let place =
            |(x, y): (f64, f64)| (70.0 + x.log10() / last * 520.0, 240.0 - y / most * 190.0);
        let mut body = String::new();
        for step in 0..5 {
            let value = most * f64::from(step) / 4.0;
            let y = place((1.0, value)).1;
            body += &format!(
                "<line class=\"g\" x1=\"70\" x2=\"590\" y1=\"{y:.1}\" y2=\"{y:.1}\"/><text x=\"62\" \
                 y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
                y + 4.0,
                number(value),
            );
        }
        for power in 0..=last as i32 {
            let x = place((10f64.powi(power), 0.0)).0;
            body += &format!(
                "<text x=\"{x:.1}\" y=\"260\" text-anchor=\"middle\">{}</text>\n",
                number(10f64.powi(power)),
            );
        }
        for (index, (name, points)) in self.lines.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let path: Vec<String> =
                points.iter().map(|p| place(*p)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            body += &format!(
                "<polyline class=\"l\" stroke=\"{colour}\" points=\"{}\"/><text x=\"80\" y=\"{}\" \
                 style=\"fill:{colour}\">{name}</text>\n",
                path.join(" "),
                44 + 18 * index,
            );
        }
        picture(640.0, 270.0, &self.title, &body)
    }
}

fn picture(width: f64, height: f64, title: &str, body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\">{STYLE}<text class=\"t\" x=\"12\" y=\"22\">{title}\
         </text>\n{body}</svg>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_is_the_greatest_figure() {
        let mut bars = Bars::new("instructions");
        bars.bar("lafet", 50.0);
        bars.bar("peer", 100.0);
        let svg = bars.svg();
        assert!(svg.contains("width=\"190.0\"") && svg.contains("width=\"380.0\""), "{svg}");
        assert!(svg.contains("class=\"o\"") && svg.contains("class=\"p\""));
    }

    #[test]
    fn lines_stay_in_the_picture() {
        let mut lines = Lines::new("cost");
        lines.line("all", vec![(1.0, 5.0), (10_000.0, 5.0)]);
        let svg = lines.svg();
        assert!(svg.contains("70.0,") && svg.contains("590.0,"), "{svg}");
    }
}
