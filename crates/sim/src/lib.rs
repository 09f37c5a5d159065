//! lafet-sim
