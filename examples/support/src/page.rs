//! A page of figures and tables, which needs no network and no script.

use crate::figure::{View, svg, write_figure};
use std::fmt::Write;
use std::path::Path;

const STYLE: &str = "
body { font: 16px/1.45 Georgia, 'Times New Roman', serif; color: #111; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; }
h2 { border-top: 1px solid #999; padding-top: 1.2rem; margin-top: 2.2rem; }
figure { margin: 1rem 0; }
figure svg { width: 100%; height: auto; display: block; }
figcaption, .note { font-size: .92rem; color: #333; }
table { border-collapse: collapse; margin: 1rem 0; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .9rem .2rem 0; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top; }
th { border-bottom: 1px solid #111; }
th:first-child, td:first-child { text-align: left; }
.wide { overflow-x: auto; }
a { color: #0072B2; }
@page { size: A4; margin: 16mm 14mm; }
@media print {
  body { max-width: none; margin: 0; padding: 0; font-size: 10pt; }
  section { break-before: page; border: 0; }
  section h2 { border: 0; margin-top: 0; padding-top: 0; }
  figure, table { break-inside: avoid; }
  figure svg { max-height: 160mm; }
  a { color: inherit; text-decoration: none; }
}
";

/// One model or study: a heading, a figure with its caption, a table.
#[derive(Clone, Debug)]
pub struct Section {
    slug: String,
    title: String,
    lead: String,
    svg: String,
    caption: String,
    table: Table,
}

impl Section {
    /// The section of a figure of so many columns, which is written to `folder` under the name `slug`, its numbers beside it.
    ///
    /// # Errors
    /// Where the figure cannot be written.
    pub fn illustrated(
        folder: &Path,
        slug: &str,
        [title, lead, caption]: [&str; 3],
        (columns, views): (usize, &[View]),
        table: Table,
    ) -> std::io::Result<Self> {
        write_figure(&folder.join(format!("{slug}.svg")), &format!("{title}: {lead}\n{caption}"), columns, views)?;
        let [slug, title, lead, caption] = [slug, title, lead, caption].map(str::to_owned);
        Ok(Section { slug, title, lead, svg: svg("", columns, views)?, caption, table })
    }
}

/// A heading for each column, and the rows.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<String>,
    /// As many cells as headings each.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Without rows.
    pub fn new<const K: usize>(columns: [&str; K]) -> Self {
        Table { columns: columns.map(String::from).to_vec(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn add<const K: usize>(&mut self, row: [String; K]) {
        self.rows.push(row.to_vec());
    }

    fn html(&self) -> String {
        let cells = |tag: &str, row: &[String]| -> String {
            row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect()
        };
        let rows: String = self.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells("td", row))).collect();
        format!(
            "<div class=\"wide\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
            cells("th", &self.columns)
        )
    }
}

/// The whole page. The first column of the summary links to the sections, in their order.
pub fn html(title: &str, lead: &str, summary: &Table, sections: &[Section]) -> String {
    let mut summary = summary.html();
    for section in sections {
        let name = escaped(&section.title);
        let link = format!("<td><a href=\"#{}\">{name}</a></td>", section.slug);
        summary = summary.replacen(&format!("<td>{name}</td>"), &link, 1);
    }
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n<p>{1}</p>\n{summary}",
        escaped(title),
        escaped(lead)
    );
    for section in sections {
        let Section { slug, title, lead, svg, caption, table } = section;
        // Writing to a string cannot fail.
        let _ = write!(
            page,
            "<section id=\"{slug}\">\n<h2>{}</h2>\n<p>{}</p>\n<figure>\n{svg}\n<figcaption>{} Numbers: \
             <a href=\"{slug}.svg.csv\">{slug}.svg.csv</a>.</figcaption>\n</figure>\n{}</section>\n",
            escaped(title),
            escaped(lead),
            escaped(caption),
            table.html()
        );
    }
    page + "</body>\n</html>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
