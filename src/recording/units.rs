//! Units that files use, and what they are in SI. Conversion happens only where files are read or written.
