//! `linewright simulate`: the bar chart that the line's own controllers produce, in virtual time.
