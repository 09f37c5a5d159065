//! Requests and answers over TCP loopback: a simulated monitor and lafet's client, beside Modbus and
//! an echo that does nothing but answer with as many bytes. Both ends run on one processor: on two,
//! the figures depend on where the kernel puts them.
//!
//! `report LAFET FOLDER` measures everything; the rest is what it starts.

mod ask;
mod contender;
mod page;
mod serve;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let Ok(runtime) = runtime else { return ExitCode::FAILURE };
    let done = match words[..] {
        ["report", lafet, folder] => page::report(lafet.as_ref(), folder.as_ref()),
        ["serve", who, port] => runtime.block_on(serve::serve(who, port)),
        ["ask", who, port, seconds] => {
            let words = [who, port, seconds].map(str::to_owned);
            // A task like any other, as in the load generator: what `block_on` itself runs is polled
            // at the price of a system call.
            runtime.block_on(async {
                let asking = async move { ask::ask(&words[0], &words[1], &words[2]).await };
                tokio::spawn(asking).await.map_err(|e| e.to_string())?
            })
        }
        ["load", port, request, answer, connections, outstanding, seconds] => {
            let numbers = [answer, connections, outstanding].map(str::parse);
            let [Ok(answer), Ok(connections), Ok(outstanding)] = numbers else {
                return ExitCode::from(2);
            };
            let load = ask::Load { request: ask::unhex(request), answer, connections, outstanding };
            runtime.block_on(load.run(port, seconds))
        }
        _ => Err("report LAFET FOLDER".into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
