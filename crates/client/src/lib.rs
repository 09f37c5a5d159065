//! lafet-client
