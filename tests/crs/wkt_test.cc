#include "src/base/crs/wkt.h"

#include <gtest/gtest.h>

#include <string>

namespace tessera {
namespace {

// What it says of a text, or nothing.
std::string fault(const std::string& text) {
  const auto checked = check_wkt(text);
  return checked ? "" : checked.error().where;
}

TEST(Wkt, ValuesOfAllKindsAreRead) {
  for (const char* text :
       {R"(PROJCS["NAD83 / UTM zone 17N",UNIT["m",1]])", " \t\r\nprojcs\v (\"x\" , unit( \"m\" , 1e-3 ) )\n",
        R"x(GEODCRS["a ""b/c"" d",AXIS["(E)",east,ORDER[1]],X[-1.5,+2,.5,2020-01-01T00:00Z]])x",
        R"(PROJCS["p",UNIT["m",1]],VERTCS["v",UNIT["m",1]])"})
    EXPECT_EQ(fault(text), "") << text;
}

TEST(Wkt, WhatIsNoneIsRefusedWithItsPlace) {
  EXPECT_EQ(fault(""), "it does not begin with the keyword of a coordinate system");
  EXPECT_EQ(fault("DATUM[\"x\"]"), "it does not begin with the keyword of a coordinate system");
  EXPECT_EQ(fault("PROJCS[\"x\""), "it ends too early");
  EXPECT_EQ(fault("PROJCS"), "it ends too early");
  EXPECT_EQ(fault("PROJCS[\"x"), "it ends within quotation marks");
  EXPECT_EQ(fault("PROJCS[\"x\"\""), "it ends within quotation marks");
  EXPECT_EQ(fault("PROJCS[\"x\")"), "it is not WKT from byte 10 on");
  EXPECT_EQ(fault("PROJCS[]"), "it is not WKT from byte 7 on");
  EXPECT_EQ(fault("PROJCS[\"x\",]"), "it is not WKT from byte 11 on");
  EXPECT_EQ(fault("PROJCS[\"x\"y]"), "it is not WKT from byte 10 on");
  EXPECT_EQ(fault("PROJCS[/etc/passwd]"), "it is not WKT from byte 7 on");
  EXPECT_EQ(fault("PROJCS[\"x\"] +init=x"), "it is not WKT from byte 12 on");
  EXPECT_EQ(fault(std::string("PROJCS[\"x\"]\0y", 13)), "it is not WKT from byte 11 on");
  EXPECT_EQ(fault("PROJCS[\xE2\x80\x9Cx\xE2\x80\x9D]"), "it is not WKT from byte 7 on");
}

TEST(Wkt, DepthAndLengthAreBounded) {
  const auto nested = [](int depth) {
    std::string text = "PROJCS[\"x\"";
    for (int i = 1; i < depth; ++i) text += ",A[1";
    return text + std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_EQ(fault(nested(16)), "");
  EXPECT_EQ(fault(nested(17)), "it is nested too deep");
  EXPECT_EQ(fault("PROJCS[\"" + std::string(65525, 'x') + "\"]"), "");
  EXPECT_EQ(fault("PROJCS[\"" + std::string(65526, 'x') + "\"]"), "it is longer than 65535 bytes");
}

TEST(Wkt, OnlyLabelsHoldSlashesAndNoLabelWithAnEqualSign) {
  const auto with = [](const std::string& keyword, const std::string& value) {
    return fault("PROJCS[\"p\"," + keyword + "[\"" + value + "\",1]]");
  };
  for (const char* keyword : {"DATUM", "SPHEROID", "UNIT", "REMARK", "unit", "Uri"}) {
    EXPECT_EQ(with(keyword, "a / b"), "") << keyword;
    EXPECT_NE(with(keyword, "a=/b"), "") << keyword;
    EXPECT_EQ(with(keyword, "a=b"), "") << keyword;
  }
  for (const char* keyword : {"EXTENSION", "extension", "PARAMETERFILE", "AUTHORITY", "ID", "METHOD", "PROJECTION",
                              "PARAMETER", "GEOIDMODEL", "MODEL", "WHATEVER"}) {
    EXPECT_NE(with(keyword, "/b"), "") << keyword;
    EXPECT_NE(with(keyword, "a\\b"), "") << keyword;
    EXPECT_EQ(with(keyword, "b"), "") << keyword;
  }
  EXPECT_EQ(with("EXTENSION", "/b"), "its EXTENSION holds a slash, so it may name a file");
}

}  // namespace
}  // namespace tessera
