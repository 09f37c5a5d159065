//! lafet-proto
