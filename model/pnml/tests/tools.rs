//! Output of tools beyond the plain standard that is read all the same.

use linewright_pnml::read;

use crate::common::{sound, with};

/// One place with a token, one transition that takes it.
const PLAIN: &str = "\
net n: places 1, transitions 1, tokens 1
  p  1
  t  p → nothing
";

#[test]
fn the_same_net_is_read_however_it_is_written() {
    let place = r#"<place id="p"><initialMarking><text>1</text></initialMarking></place>"#;
    let rest = r#"<transition id="t"/><arc id="a" source="p" target="t"/>"#;
    let arc =
        |inside: &str| with(&format!("{place}<transition id=\"t\"/><arc id=\"a\" source=\"p\" target=\"t\"{inside}"));
    let files = [
        with(&format!("{place}{rest}")),
        with(&format!("<page id=\"g\">{place}{rest}</page>")),
        with(&format!("<page id=\"g\">{place}</page><page id=\"h\">{rest}</page>")),
        with(&format!("{}{place}{}{rest}", "<page>".repeat(40), "</page>".repeat(40))),
        with(&format!("{rest}{place}")),
        with(&format!("<page id=\"g\"><name><text>a page</text></name>{place}{rest}</page>")),
        // Prefixes, a default namespace, an older type, a document type, instructions, a byte order mark.
        "<p:pnml xmlns:p=\"u\"><p:net id=\"n\"><p:place id=\"p\"><p:initialMarking><p:text>1</p:text></p:initialMarking>\
         </p:place><p:transition id=\"t\"/><p:arc id=\"a\" source=\"p\" target=\"t\"/></p:net></p:pnml>"
            .to_owned(),
        format!("\u{FEFF}<?xml version='1.0'?>\n<!DOCTYPE pnml SYSTEM \"x.dtd\" [<!ENTITY a \"b\">]><?tool x?>{}", with(&format!("{place}{rest}"))),
        format!("<pnml xmlns=\"u\"><net id=\"n\" type=\"http://www.informatik.hu-berlin.de/top/pntd/ptNetb\">{place}{rest}</net></pnml>"),
        format!("<pnml><net id=\"n\" type=\"P/T net\">{place}{rest}</net></pnml>"),
        format!("<pnml><net id=\"n\" type=\"\">{place}{rest}</net><other><net id=\"m\"/></other></pnml>"),
        // Drawings, remarks of tools, unknown elements and comments, anywhere.
        with(&format!(
            "<toolspecific tool=\"x\"><place id=\"p\"/><arc source=\"q\"/></toolspecific><!-- <place id=\"q\"/> -->\
             <graphics><arc source=\"x\" target=\"y\"/></graphics><labels><place id=\"z\"/></labels>{place}{rest}"
        )),
        with(&format!("<place id=\"p\"><graphics><position x=\"1\" y=\"2\"/></graphics><initialMarking>\n <graphics/><text>\n  <!-- one -->1\n </text></initialMarking><toolspecific><initialMarking><text>7</text></initialMarking></toolspecific></place>{rest}")),
        with(&format!("<place id=\"p\"><initialMarking><text><![CDATA[ 1 ]]></text></initialMarking></place>{rest}")),
        with(&format!("<place id=\"p\"><initialMarking><text>&#49;</text></initialMarking></place>{rest}")),
        // Labels as PIPE and TAPAAL write them.
        with(&format!("<place id=\"p\"><initialMarking><value>Default,1</value></initialMarking><capacity><value>0</value></capacity></place>{rest}")),
        with(&format!("<place id=\"p\" initialMarking=\"1\"/>{rest}")),
        // Text that stands in the label itself, and labels with more than their text.
        with(&format!("<place id=\"p\"><name>p</name><initialMarking>\n 1 </initialMarking></place>{rest}")),
        with(&format!("<place id=\"p\"><initialMarking><graphics/>1</initialMarking></place>{rest}")),
        with(&format!("<place id=\"p\"><initialMarking>1<value>1</value><more/></initialMarking></place>{rest}")),
        arc("><inscription>1</inscription><type>normal</type></arc>"),
        arc("><inscription><value>Default,1</value></inscription><type value=\"normal\"/></arc>"),
        arc(" type=\"normal\" inscription=\"1\"/>"),
        arc("><inscription><text>1</text><graphics/></inscription><arctype><text>ordinary</text></arctype></arc>"),
        arc("><inscription><graphics/></inscription></arc>"),
        arc("><inscription><text/></inscription></arc>"),
        with(&format!("{place}<transition id=\"t\"><priority><value>1</value></priority></transition><arc source=\"p\" target=\"t\"/>")),
        // References, over several pages and in chains.
        with(&format!(
            "<page id=\"g\">{place}<referencePlace id=\"r\" ref=\"s\"/></page><page id=\"h\"><referencePlace id=\"s\" ref=\"p\"/>\
             <referenceTransition id=\"u\" ref=\"t\"/><transition id=\"t\"/><arc id=\"a\" source=\"r\" target=\"u\"/></page>"
        )),
    ];
    for file in files {
        assert_eq!(sound(&file).to_string(), PLAIN, "{file}");
    }
}

#[test]
fn parallel_arcs_move_the_sum_of_their_weights() {
    let net = sound(&with(
        r#"<place id="p"/><referencePlace id="r" ref="p"/><transition id="t"/>
        <arc id="a" source="p" target="t"/><arc id="b" source="p" target="t"/>
        <arc id="c" source="r" target="t"><inscription><text>3</text></inscription></arc><arc id="d" source="t" target="p"/>"#,
    ));
    let t = net.transition_named("t").unwrap();
    assert_eq!((net.preset(t)[0].1, net.postset(t)[0].1), (5, 1));
}

#[test]
fn names_are_taken_where_they_are_unique_and_ids_where_they_are_not() {
    let place = |id: &str, name: &str| format!("<place id=\"{id}\"><name><text>{name}</text></name></place>");
    let names = |places: &[(&str, &str)]| {
        let net = sound(&with(&places.iter().map(|(id, name)| place(id, name)).collect::<String>()));
        net.places().map(|p| net.place_name(p).to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(&[("a", "home"), ("b", "  press\n")]), ["home", "press"]);
    assert_eq!(names(&[("a", "home"), ("b", "home"), ("c", "press"), ("d", "home")]), ["a", "b", "press", "d"]);
    assert_eq!(names(&[("a", ""), ("b", "press")]), ["a", "press"]);
    // The names of two are the ids of others; as none goes by its id, there is no confusion.
    assert_eq!(names(&[("a", "b"), ("b", "a")]), ["b", "a"]);
    // `c` is called `a`, but `a` has to go by its id, and so on down the line.
    assert_eq!(names(&[("a", "x"), ("b", "x"), ("c", "a"), ("d", "c"), ("e", "y")]), ["a", "b", "c", "d", "y"]);
    // A place and a transition of the same name are not mixed up.
    let both = with(
        "<place id=\"a\"><name><text>x</text></name></place><transition id=\"b\"><name><text>x</text></name></transition>",
    );
    assert!(sound(&both).place_named("x").is_some() && sound(&both).transition_named("x").is_some());
}

#[test]
fn the_net_is_called_by_its_name_or_its_id_and_not_by_its_page() {
    assert_eq!(
        sound("<pnml><net id=\"n\"><page id=\"g\"><name><text>page</text></name><place id=\"p\"/></page></net></pnml>")
            .name(),
        "n"
    );
    assert_eq!(
        sound("<pnml><net id=\"n\"><place id=\"p\"/><name><text>cell</text></name></net></pnml>").name(),
        "cell"
    );
    assert_eq!(sound("<pnml><net><place id=\"p\"/></net></pnml>").name(), "net");
}

#[test]
fn one_of_several_nets_is_read_by_its_id() {
    let file =
        b"<pnml><net id=\"a\"><place id=\"p\"/></net><net id=\"b\"><place id=\"p\"/><place id=\"q\"/></net></pnml>";
    let places = |net| read("nets.pnml", file, Some(net)).unwrap().place_count();
    assert_eq!((places("a"), places("b")), (1, 2));
    // Errors of a net do not affect the others.
    let file = b"<pnml><net id=\"a\"><place/></net><net id=\"b\"><place id=\"p\"/></net></pnml>";
    assert!(read("nets.pnml", file, Some("b")).is_ok() && read("nets.pnml", file, Some("a")).is_err());
}

#[test]
fn latin_1_is_read_where_it_is_declared() {
    let file = b"<?xml version='1.0' encoding='iso-8859-1'?><pnml><net id='n'><place id='p'><name><text>Pr\xFCfen</text></name></place></net></pnml>";
    let net = read("net.pnml", file, None).unwrap();
    assert!(net.place_named("Prüfen").is_some());
    // .NET programs declare UTF-16 and write UTF-8; as long as it is ASCII, nothing can go wrong.
    let file = b"<?xml version=\"1.0\" encoding=\"utf-16\"?><pnml><net id='n'><place id='p'/></net></pnml>";
    assert!(read("net.pnml", file, None).is_ok());
}
