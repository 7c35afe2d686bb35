"""The text of programs: the linker of WGSL files, and structs that host and device share."""
