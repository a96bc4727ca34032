//! `report.html`: one file that opens offline.

use super::{
    Figure,
    key_figures::{Ending, headline, key_figures, link_figures},
    replay::{recording, stride},
    svg::escape,
};
use crate::flight::Flight;

const PAGE: &str = include_str!("../../assets/report.html");
/// How a page looks.
pub const CSS: &str = include_str!("../../assets/report.css");

/// The whole page. Download links lead to the figures' files beside it.
pub fn page(flight: &Flight, figures: &[Figure]) -> Result<String, serde_json::Error> {
    let summary = &flight.summary;
    let (status, status_class) = Ending::of(summary).label();
    let subtitle = format!(
        "Scenario {}, seed {}; {} with the {} preset; transport: {}",
        summary.scenario, summary.seed, summary.algorithm, summary.preset, summary.transport
    );
    Ok(fill(
        PAGE,
        &[
            ("title", &escape(&format!("{}: {}", summary.scenario, headline(summary)))),
            ("css", CSS),
            ("status", status),
            ("status-class", status_class),
            ("headline", &escape(&headline(summary))),
            ("subtitle", &escape(&subtitle)),
            ("key-figures", &key_figure_list(flight)),
            ("replay", &replay(flight)?),
            ("figures", &figures.iter().map(figure).collect::<String>()),
            ("safe-distance", &flight.field.safe_distance_m.to_string()),
            ("collision-distance", &flight.field.collision_distance_m.to_string()),
            ("settings", &settings(flight)),
            ("version", &escape(&summary.version)),
        ],
    ))
}

fn key_figure_list(flight: &Flight) -> String {
    let item = |(name, value, note): (&str, String, String)| {
        let note = if note.is_empty() { note } else { format!("<small>{}</small>", escape(&note)) };
        format!("    <div><dt>{}</dt><dd>{}{note}</dd></div>\n", escape(name), escape(&value))
    };
    key_figures(flight).into_iter().map(item).collect()
}

/// The page of the live view, in a frame of its own.
fn replay(flight: &Flight) -> Result<String, serde_json::Error> {
    if flight.trajectory.ticks.is_empty() {
        return Ok("  <p>The flight ended before its first tick: there is nothing to replay.</p>".to_owned());
    }
    let page = escape(&live_view::assets::page_of(&mut recording(flight))?);
    let thinned = match stride(flight) {
        1 => String::new(),
        stride => format!("\n  <p class=\"sub\">The flight is long: the replay has one of every {stride} ticks.</p>"),
    };
    Ok(format!("  <iframe title=\"Replay\" class=\"replay\" srcdoc=\"{page}\"></iframe>{thinned}"))
}

fn figure(Figure { name, title, caption, svg }: &Figure) -> String {
    format!(
        "    <figure id=\"{name}\">\n      <h3>{}</h3>\n{svg}      <figcaption>{} \
         <a href=\"figures/{name}.svg\" download>SVG</a> <a href=\"figures/{name}.png\" \
         download>PNG</a></figcaption>\n    </figure>\n",
        escape(title),
        escape(caption)
    )
}

fn settings(flight: &Flight) -> String {
    let settings = flight.settings.iter().map(|setting| (setting.name.clone(), setting.value.clone()));
    let link = link_figures(&flight.summary);
    let mut html = table("Setting", "Value", settings.collect());
    if !link.is_empty() {
        html.push_str("\n  <h2>Counters of the link</h2>\n");
        html.push_str(&table("Counter", "Value", link));
    }
    html
}

fn table(name: &str, value: &str, rows: Vec<(String, String)>) -> String {
    if rows.is_empty() {
        return "  <p>None were recorded.</p>".to_owned();
    }
    let row = |(name, value): (String, String)| {
        format!("    <tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(&name), escape(&value))
    };
    let body: String = rows.into_iter().map(row).collect();
    format!(
        "  <table>\n    <thead><tr><th scope=\"col\">{name}</th><th scope=\"col\">{value}</th></tr></thead>\n    \
         <tbody>\n{body}    </tbody>\n  </table>"
    )
}

/// The template with every `{{name}}` replaced. What is put in is not searched again, so no value can call up another.
pub fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut filled = String::with_capacity(template.len() + values.iter().map(|(_, value)| value.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        filled.push_str(before);
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        if let Some((_, value)) = values.iter().find(|(known, _)| *known == name) {
            filled.push_str(value);
        }
        rest = after;
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        flight::Setting,
        report::{figures, sample},
    };

    fn page_of(flight: &Flight) -> String {
        page(flight, &figures::all(flight)).unwrap()
    }

    /// The page without the frames of the replay, which may spell anything, and its script, which names what is no
    /// number.
    fn without_script(page: &str) -> String {
        match (page.find("&lt;script type=&quot;text/plain"), page.rfind("&lt;/script&gt;")) {
            (Some(from), Some(to)) => page[..from].to_owned() + &page[to..],
            _ => page.to_owned(),
        }
    }

    #[test]
    fn every_placeholder_is_filled_once_and_values_are_not_searched() {
        assert_eq!(fill("a {{x}} b {{y}}", &[("x", "{{y}}"), ("y", "2")]), "a {{y}} b 2");
        assert!(!page_of(&sample::flight(2, 1, 3)).contains("{{"));
    }

    #[test]
    fn nothing_a_user_writes_becomes_markup() {
        let evil = "</script><script>alert('1')</script>&\"{{data}}";
        let mut flight = sample::flight(2, 1, 3);
        flight.summary.scenario = evil.into();
        flight.summary.failure = Some(evil.into());
        flight.summary.preset = evil.into();
        flight.summary.version = evil.into();
        flight.summary.link = serde_json::json!({ evil: evil });
        flight.settings = vec![Setting { name: evil.into(), value: evil.into() }];
        let page = page_of(&flight);
        assert!(!page.contains("alert('1')"));
        // The replay is a page within an attribute.
        assert_eq!((page.matches("<script").count(), page.matches("</script>").count()), (0, 0));
        assert_eq!(page.matches("&lt;/script&gt;\n").count(), 3);
        assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(&#39;1&#39;)"));
    }

    #[test]
    fn the_page_asks_nothing_of_the_network() {
        let page = page_of(&sample::flight(5, 7, 20));
        let without_namespace = page.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http:", "https:", "src=", "@import", "fetch(", "XMLHttpRequest"] {
            assert!(!without_namespace.contains(outside), "{outside}");
        }
    }

    #[test]
    fn flights_with_nothing_to_show_are_pages_all_the_same() {
        for (vehicles, obstacles, ticks) in [(0, 0, 0), (5, 7, 0), (1, 0, 1), (1, 0, 5), (2, 1, 1)] {
            let page = page_of(&sample::flight(vehicles, obstacles, ticks));
            assert!(page.ends_with("</html>\n"));
            assert_eq!(page.contains("id=&quot;stage&quot;"), ticks > 0);
            assert!(
                !without_script(&page).contains("NaN") && !without_script(&page).contains("inf"),
                "{vehicles} {obstacles} {ticks}"
            );
        }
    }

    #[test]
    fn every_figure_is_there_with_its_files() {
        let page = page_of(&sample::flight(2, 1, 3));
        for name in figures::NAMES {
            assert!(page.contains(&format!("href=\"figures/{name}.svg\"")), "{name}");
            assert!(page.contains(&format!("href=\"figures/{name}.png\"")), "{name}");
        }
        assert_eq!(page.matches("<svg").count(), figures::NAMES.len());
    }
}
