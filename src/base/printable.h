// Texts of strangers, on their way to a terminal, a log or a sentence: names of files and results, attributes, systems,
// what a server says.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

// `text` on one line that shows what it holds: ' ' for ends of lines and tabs, '?' for what is not UTF-8, for control
// characters (C0, DEL and C1, which
// terminals obey), for the separators of lines and paragraphs (U+2028, U+2029), and for what turns the direction of
// writing around (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069).
std::string printable(std::string_view text);

// The same, of lines: their ends stay.
std::string printable_lines(std::string_view text);

// In quotation marks, for sentences: the beginning of a long one.
std::string in_quotes(std::string_view text);

// Whether the code point that begins `text`, of `length` bytes (utf8.h), is shown as it is.
bool is_printable(std::string_view text, std::size_t length);

}  // namespace tessera
