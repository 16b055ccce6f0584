#include "src/base/files/fits_cards.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <string>

namespace tessera {
namespace {

std::string card(const std::string& header, std::size_t i) {
  const std::string line = header.substr(80 * i, 80);
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

TEST(FitsCards, AreLinesOfBlocks) {
  FitsCards cards;
  cards.flag("SIMPLE", true);
  cards.whole("BITPIX", -64);
  cards.whole("NAXIS1", std::uint64_t{1} << 40);
  cards.text("OBJECT", "it's");
  cards.text("BUNIT", "\xc3\xa9\n");
  cards.comment("");
  cards.comment(std::string(100, 'c'));
  const std::string header = cards.end();
  ASSERT_EQ(header.size(), fits_block_bytes);
  EXPECT_EQ(card(header, 0), "SIMPLE  =                    T");
  EXPECT_EQ(card(header, 1), "BITPIX  =                  -64");
  EXPECT_EQ(card(header, 2), "NAXIS1  =        1099511627776");
  EXPECT_EQ(card(header, 3), "OBJECT  = 'it''s   '");
  EXPECT_EQ(card(header, 4), "BUNIT   = '___     '");
  EXPECT_EQ(card(header, 5), "COMMENT " + std::string(72, 'c'));
  EXPECT_EQ(card(header, 6), "COMMENT " + std::string(28, 'c'));
  EXPECT_EQ(card(header, 7), "END");
  EXPECT_EQ(header.find_last_not_of(' '), 80 * 7 + 2U);
  EXPECT_EQ(cards.end().size(), fits_block_bytes);  // a new header
}

TEST(FitsCards, HaveAllDigits) {
  for (const double number : {0.1, 1.0, -2e300, 1 / 3.0, 5e-324, 360.0, std::numeric_limits<double>::max()}) {
    FitsCards cards;
    cards.real("CDELT1", number);
    const std::string value = card(cards.end(), 0).substr(10);
    EXPECT_EQ(std::strtod(value.c_str(), nullptr), number);
    EXPECT_NE(value.find_first_of(".E"), std::string::npos) << value;
  }
}

TEST(FitsCards, CutLongTextsBetweenCharacters) {
  FitsCards cards;
  cards.text("OBJECT", std::string(67, 'a') + "'b");
  cards.text("OBJECT", std::string(90, 'a'));
  const std::string header = cards.end();
  EXPECT_EQ(card(header, 0), "OBJECT  = '" + std::string(67, 'a') + "'");
  EXPECT_EQ(card(header, 1), "OBJECT  = '" + std::string(68, 'a') + "'");
}

TEST(FitsCards, FillBlocks) {
  EXPECT_EQ(fits_blocks_of(0), 0U);
  EXPECT_EQ(fits_blocks_of(1), 2880U);
  EXPECT_EQ(fits_blocks_of(2880), 2880U);
  EXPECT_EQ(fits_blocks_of(2881), 5760U);
}

}  // namespace
}  // namespace tessera
