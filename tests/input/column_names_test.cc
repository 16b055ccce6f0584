#include "src/input/column_names.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "src/input/cloud/cloud.h"
#include "src/input/cloud/cloud_sample.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

using Names = std::vector<std::string>;
using By = CoordinateColumns::By;

// As surveyors have it: number, northing, easting, height, code.
const std::string survey = "7,6000084.74,500013.44,7.64,GND\n8,6000090.5,500020,8,\"EP, CURB\"\n";
const std::vector<Point> surveyed{{500013.44, 6000084.74, 7.64}, {500020, 6000090.5, 8}};

Result<Contents> read_named(const std::string& text, const Names& names, std::vector<Attribute> schema = {}) {
  return read_bytes(bytes_of(text), "a.csv", std::move(schema), {.columns = names});
}

std::string refusal(const Names& names) {
  const Status status = check_columns(names);
  return status ? "" : status.error().where;
}

TEST(ColumnNames, SayWhichColumnIsWhatWhateverTheHeaderSays) {
  for (const std::string header : {"", "number,northing,easting,height,code\n", "z,x,y,a,b\n", "# nothing\n"}) {
    const std::vector<Attribute> schema{{"p", AttributeType::u32}};
    const auto read = read_named(header + survey, {"p", "y", "X", "z"}, schema);
    ASSERT_EQ(sentence(read), "") << header;
    EXPECT_EQ(read.value().points, surveyed) << header;
    EXPECT_EQ(read.value().info.attributes, (std::vector<Attribute>{{"p", AttributeType::f64}}));
    EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 1, 0), 8u);
    EXPECT_EQ(read.value().info.columns->numbers, (std::vector<std::size_t>{3, 2, 4}));
    EXPECT_EQ(read.value().info.columns->by, By::option);
    EXPECT_FALSE(read.value().info.counts_up);
  }
}

TEST(ColumnNames, ColumnsWithoutANameMayHoldWords) {
  const auto read = read_named("GND,1,2.5,-3,x\nEP,4,5,6,y\n", {"_", "x", "y", "z"});
  ASSERT_EQ(sentence(read), "") << "a word in the first column makes no header";
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2.5, -3}, {4, 5, 6}}));
  EXPECT_TRUE(read.value().info.attributes.empty());
  EXPECT_EQ(read_named(survey, {"_", "y", "x"}).value().info.dimension, 2);
  const auto words = read_named(survey, {"_", "y", "x", "z", "code"});
  EXPECT_EQ(words.value().points, surveyed);
  EXPECT_TRUE(words.value().info.attributes.empty()) << "words are no attribute, as below a header";
}

TEST(ColumnNames, NameTheColumnsOfArraysToo) {
  std::string literal = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 4), }";
  Bytes bytes = bytes_of("\x93NUMPY\x01");
  bytes.push_back(std::byte{0});
  push(bytes, static_cast<std::uint16_t>(literal.size()));
  const Bytes text = bytes_of(literal);
  bytes.insert(bytes.end(), text.begin(), text.end());
  for (const double v : {7, 2, 1, 3, 8, 5, 4, 6}) push(bytes, v);
  const std::vector<Attribute> schema{{"p", AttributeType::u8}};
  const auto read = read_bytes(bytes, "a.npy", schema, {.columns = {"p", "y", "x", "z"}});
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 0), 8);
  EXPECT_EQ(read.value().info.columns->numbers, (std::vector<std::size_t>{3, 2, 4}));
  EXPECT_EQ(sentence(read_bytes(bytes, "a.npy", {}, {.columns = {"x", "y", "_", "_", "z"}})),
            "a.npy: has 4 columns, but columns names 5");
}

TEST(ColumnNames, ThatMakeNoPointsAreRefused) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({"x", "y"}), "");
  EXPECT_EQ(refusal({"p", "y", "z"}), "no column is called x");
  EXPECT_EQ(refusal({"x", "z"}), "no column is called y");
  EXPECT_EQ(refusal({"x", "y", "X"}), "'X' is there twice");
  EXPECT_EQ(refusal({"x", "a", "y", "a"}), "'a' is there twice");
  EXPECT_EQ(refusal({"_", "_", "x", "y"}), "");
  EXPECT_EQ(refusal({"x", "", "y"}), "a name is empty; _ leaves a column out");
  EXPECT_EQ(refusal(Names(5000, "_")), "there are more than 4096 names");
  EXPECT_EQ(sentence(read_named("1,2,3\n", {"p", "x", "y", "z", "_"})),
            "a.csv, line 1: has 3 columns, but columns names 4");
  EXPECT_EQ(sentence(read_named("1,2,3\n4,five,6\n", {"x", "y"})), "a.csv, line 2: y is 'five', not a number");
}

TEST(ColumnNames, WithoutThemAFirstColumnThatCountsUpIsTold) {
  const auto counts = [](const std::string& text) { return read_text(text, "a.csv").value().info.counts_up; };
  EXPECT_TRUE(counts("1,600,500,7,GND\n2,601,500,8,GND\n3,602,501,8,EP\n"));
  EXPECT_TRUE(counts("point,a,b,c\n10,600,500,7\n11,601,500,8\n12,602,501,8\n")) << "the header names no x and y";
  EXPECT_FALSE(counts("p,n,e,z\n1,600,500,7\n2,601,500,8\n3,602,501,8\n")) << "the header does";
  EXPECT_FALSE(counts("1,600,500,7\n2,601,500,8\n")) << "two are too few to tell";
  EXPECT_FALSE(counts("1,600,500,7\n2,601,500,8\n4,602,501,8\n"));
  EXPECT_FALSE(counts("1,600,500,7\n2,600,501,8\n3,600,502,8\n")) << "a row of a raster";
  EXPECT_FALSE(counts("1.0,600,500,7\n2.0,601,500,8\n3.0,602,501,8\n"));
  EXPECT_FALSE(counts("1,5\n2,7\n3,9\n")) << "nothing is left for x and y";
}

TEST(ColumnNames, OfFitsAreEntriesThatTogetherMakeAPoint) {
  using Entries = std::vector<std::pair<std::string, std::string>>;
  const auto why = [](const Names& names) {
    const Status status = check_columns(names);
    return status ? std::string() : status.error().where;
  };
  for (const Names& good : {Names{"x=A", "y=B"}, Names{"z=A=B", "y=x", "x=C"}, Names{"position=P"},
                            Names{"dec=D", "ra=R", "redshift=Z"}, Names{"ra=R", "dec=D", "distance=Z"}})
    EXPECT_EQ(why(good), "");
  EXPECT_EQ(why({"x=A", "y="}), "'y=' is not KEY=COLUMN, as x=XPOS");
  EXPECT_EQ(why({"x=A", "y"}), "'y' is not KEY=COLUMN, as x=XPOS");
  const std::string keys =
      "the keys must be x,y or x,y,z, or position, or ra,dec,distance, or ra,dec,redshift, as in x=XPOS,y=YPOS,z=ZPOS";
  for (const Names& bad : {Names{"x=A"}, Names{"x=A", "x=B"}, Names{"x=A", "y=B", "y=C"}, Names{"ra=A", "dec=B"},
                           Names{"x=A", "y=B", "z=C", "mass=D"}, Names{"=A"}, Names{"position=A", "x=B"}})
    EXPECT_EQ(why(bad), keys);
  EXPECT_EQ(named_columns(Names{"redshift=a=b", "ra=c", "dec=d"}),
            (Entries{{"ra", "c"}, {"dec", "d"}, {"redshift", "a=b"}}));
}

TEST(ColumnNames, OfACloudAreForFilesThatHaveColumns) {
  const TempFolder folder;
  const auto path = folder.write("a.csv", survey + "9,6000091,500021,9,GND\n").string();
  const auto told = Cloud::open({path}, {});
  ASSERT_TRUE(told);
  EXPECT_EQ(told.value().warnings(),
            (Names{path + " has no header that names x and y, and a first column that counts up by one from line to "
                          "line, which is taken for x; if it numbers the points, name the columns by the option "
                          "columns, as p,y,x,z"}));
  const CloudOptions named{.columns = {"p", "y", "x", "z"}};
  const auto cloud = Cloud::open({path}, named);
  ASSERT_TRUE(cloud);
  EXPECT_TRUE(cloud.value().warnings().empty());
  std::vector<Point> points;
  const auto visit = [&](CloudBatch& batch) -> Status {
    for (const auto& p : batch.points) points.push_back(p.at);
    return success();
  };
  ASSERT_TRUE(cloud.value().for_each_batch(visit));
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0], surveyed[0]);
  EXPECT_EQ(sample_cloud(cloud.value(), 10).value().front(), surveyed[0]);
  const auto ply = folder.write("a.off", "OFF\n1 0 0\n1 2 3\n").string();
  EXPECT_EQ(sentence(Cloud::open({ply}, named)),
            "columns: none of the input files is text or NumPy, and other files have no columns");
  EXPECT_TRUE(Cloud::open({ply, path}, named));
}

}  // namespace
}  // namespace tessera::testing_io
