// Makes foreign texts safe for a terminal, a log or a sentence: names of files and results, attributes, coordinate
// systems, answers of servers.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

// Returns `text` on one line. Ends of lines and tabs become ' '. These become '?': bytes that are not UTF-8, control
// characters, which terminals obey (C0, DEL and C1), separators of lines and paragraphs (U+2028, U+2029), and
// characters that turn the direction of writing around (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069).
std::string printable(std::string_view text);

// The same for several lines: ends of lines stay.
std::string printable_lines(std::string_view text);

// Returns the printable text in quotation marks, for sentences. A text of more than 40 bytes is cut.
std::string in_quotes(std::string_view text);

// Whether the code point of `length` bytes (utf8.h) that begins `text` is printed unchanged.
bool is_printable(std::string_view text, std::size_t length);

}  // namespace tessera
