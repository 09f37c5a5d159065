//! lafet-device
