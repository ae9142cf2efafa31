//! A text put together from another one, and its problems put back.

use linewright_text::{Problem, Report, Splice};

#[test]
fn problems_are_put_back_where_people_wrote_it() {
    let old = "a = {x}; use 1; use 2";
    let mut splice = Splice::default();
    for (number, at) in [("1", 9..14), ("2", 16..21)] {
        let note = splice.note(at.clone(), format!("used for {number}"), number);
        splice.copy(old, 0..4, Some(note));
        splice.put(number, 4..7, Some(note));
        splice.end_line();
    }
    assert_eq!(splice.text(), "a = 1\na = 2\n");
    let mut report = Report::default();
    report.add(Problem::error(4..5, "1 is wrong"));
    report.add(Problem::error(10..11, "2 is wrong").also(&(0..1), "here"));
    report.add(Problem::error(6..7, "only the second"));
    splice.put_back(old, &mut report);
    let problems = report.into_problems("f", old).into_vec();
    let found: Vec<_> = problems.iter().map(|p| (p.span.clone(), p.message.as_str(), p.also.clone())).collect();
    let second = (0..1, "only the second", vec![(16..21, "used for 2".to_owned())]);
    let both = (4..7, "1 is wrong", vec![(9..14, "used for 1, and 1 more".to_owned())]);
    assert_eq!(found, [second, both]);
}

#[test]
fn a_text_as_it_is_leaves_problems_where_they_are() {
    let splice = Splice::whole("some text");
    let mut report = Report::default();
    report.add(Problem::error(5..9, "a").also(&(0..4), "b"));
    report.add(Problem::warning(0..0, "c"));
    report.add(Problem::warning(9..9, "d"));
    splice.put_back("some text", &mut report);
    let problems = report.into_problems("f", "some text").into_vec();
    let spans: Vec<_> = problems.iter().map(|problem| problem.span.clone()).collect();
    assert_eq!((spans, &problems[1].also), (vec![0..0, 5..9, 9..9], &vec![(0..4, "b".to_owned())]));
}
