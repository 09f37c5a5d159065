//! Cameras that are not ours, through the real program: a hub, its processes, viewers.

mod foreign;
mod proxy;
mod site;
