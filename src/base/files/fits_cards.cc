#include "src/base/files/fits_cards.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t card_bytes = 80, key_bytes = 8, number_bytes = 20, text_bytes = 68, least_text_bytes = 8;

std::string printable_of(std::string_view text) {
  std::string printable(text);
  std::replace_if(
      printable.begin(), printable.end(), [](char c) { return c < ' ' || c > '~'; }, '_');
  return printable;
}

}  // namespace

void FitsCards::real(std::string_view key, double value) {
  std::array<char, 32> digits{};
  std::string text(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  std::replace(text.begin(), text.end(), 'e', 'E');
  if (text.find_first_of(".E") == std::string::npos) text += ".0";
  add(key, text);
}

void FitsCards::text(std::string_view key, std::string_view value) {
  std::string quoted;
  for (const char c : printable_of(value)) {
    if (quoted.size() + (c == '\'' ? 2 : 1) > text_bytes) break;
    quoted += c;
    if (c == '\'') quoted += c;
  }
  if (quoted.size() < least_text_bytes) quoted.resize(least_text_bytes, ' ');
  std::string card(key);
  card.resize(key_bytes, ' ');
  line(card + "= '" + quoted + "'");
}

void FitsCards::comment(std::string_view text) {
  constexpr std::string_view key = "COMMENT ";
  const std::string printable = printable_of(text);
  for (std::size_t from = 0; from < printable.size(); from += card_bytes - key.size())
    line(std::string(key) + printable.substr(from, card_bytes - key.size()));
}

void FitsCards::add(std::string_view key, std::string_view value) {
  std::string card(key);
  card.resize(key_bytes, ' ');
  card += "= ";
  if (value.size() < number_bytes) card.append(number_bytes - value.size(), ' ');
  line(card + std::string(value));
}

std::string FitsCards::end() {
  line("END");
  text_.resize(fits_blocks_of(text_.size()), ' ');
  return std::exchange(text_, {});
}

void FitsCards::line(std::string text) {
  text.resize(card_bytes, ' ');
  text_ += text;
}

}  // namespace tessera
