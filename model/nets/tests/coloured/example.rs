//! The example of `docs/nets.md`.

use linewright_nets::coloured::{ColouredBuilder, Domain, Guard, abs, colour, explore, id, proj};

#[test]
fn the_example_of_the_documentation_says_what_it_says() {
    let mut b = ColouredBuilder::new("cell");
    let machine = b.named_basic("M", ["drill", "mill"]);
    let part = b.basic("P", 2);
    let free = b.place("free", machine);
    let robot = b.place("robot", Domain::Uncoloured);
    let waiting = b.place("waiting", part);
    let carried = b.place("carried", [machine, part]);
    let worked_on = b.place("worked on", [machine, part]);
    b.tokens(free, &[1], 1).tokens(free, &[2], 1).tokens(robot, &[], 1);
    b.tokens(waiting, &[1], 2).tokens(waiting, &[2], 2);

    let take = b.transition("take", Domain::Universal);
    b.input(take, free, proj([1])).input(take, robot, abs()).input(take, waiting, proj([2])).output(
        take,
        carried,
        id(),
    );
    b.guard(take, Guard::any([[colour(1, 1), colour(2, 1)], [colour(1, 2), colour(2, 2)]]));
    let put = b.transition("put", Domain::Universal);
    b.input(put, carried, id()).output(put, worked_on, id()).output(put, robot, abs());
    let finish = b.transition("finish", Domain::Universal);
    b.input(finish, worked_on, id()).output(finish, free, proj([1])).output(finish, waiting, proj([2]));

    let net = b.build().expect("all problems would be listed here");
    let reached = explore(&net, 1000).expect("or: undecided after 1000 states");
    assert_eq!((reached.states().len(), reached.deadlocks().count()), (8, 0));
    let modes: Vec<_> = net.modes(take).map(|mode| net.mode_name(mode)).collect();
    assert_eq!(modes, ["take<drill,1>", "take<mill,2>"]);
}
