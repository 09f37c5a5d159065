use lafet_sim::scenario::Scenario;
fn main(){ let f=std::env::args().nth(1).unwrap(); let t=std::fs::read_to_string(&f).unwrap();
 match Scenario::parse(&f,&t).and_then(|s| s.run(&mut |l| println!("{l}"))) { Ok(r)=>println!("{r:?}"), Err(e)=>println!("FAIL {e}") } }
