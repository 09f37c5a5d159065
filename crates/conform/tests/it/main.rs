//! Tests of the tester, in one program: it is linked once.

mod harm;
mod odd_answers;
mod pages;
mod profiles;
mod support;
mod update;
mod wrong;
mod wrong_monitors;
