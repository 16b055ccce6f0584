#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

std::string refusal(const std::string& text) { return sentence(read_text(text, "a.obj")); }

TEST(ObjReader, ReadsEveryVertexAndNothingElse) {
  const auto read = read_text(
      "\xEF\xBB\xBF# a scene\r\nmtllib a.mtl\r\no first\r\nv 0 0 0.5\r\n  v\t1   -2.5 0 # behind\r\nvt 7 7\nvn 0 0 1\n"
      "f 1/1/1 2/1/1 3/1/1\nvp 3 4 5\nverts 1 2 3\nv 1e300 0 0 1.0\nf 1 2 \\\n 3\n#v 9 9 9\nv 5 5 5",
      "a.obj");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, (std::vector<Point>{{0, 0, 0.5}, {1, -2.5, 0}, {1e300, 0, 0}, {5, 5, 5}}))
      << "the last one is used by no face";
  EXPECT_EQ(read.value().info.format, "obj");
  EXPECT_EQ(read.value().info.detail, "OBJ, text");
  EXPECT_EQ(read.value().info.points, std::nullopt);
}

TEST(ObjReader, JoinsContinuedLines) {
  const auto read = read_text("v 1 \\\n2\\\r\n 3\nf 1 2 \\\nv 7 7 7\nv 4 5 6 \\\n", "a.obj");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}})) << "the second v belongs to the face";
  auto reader = open_bytes(bytes_of("v 1 2 3\nv \\\n4 5 nan\n"), "a.obj");
  PointBatch batch;
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  EXPECT_TRUE(std::isnan(batch.points[1].z));
  EXPECT_EQ(reader.value()->place(0), "line 1");
  EXPECT_EQ(reader.value()->place(1), "line 3");
}

TEST(ObjReader, RefusesLinesWithoutEnd) {
  std::string endless = "v 0 0 0\nf";
  for (int i = 0; i < 3000; ++i) endless += std::string(400, ' ') + "\\\n";
  EXPECT_NE(refusal(endless).find("longer than 1 MiB"), std::string::npos);
  EXPECT_NE(refusal("v 0 0 0\nf" + std::string(3 << 20, ' ')).find("line 2: is longer than 1 MiB"), std::string::npos);
}

TEST(ObjReader, ColoursOfVerticesBecomeAttributes) {
  const std::vector<Attribute> schema{{"blue", AttributeType::f64}, {"red", AttributeType::f32}};
  const auto read = read_text("v 1 2 3 .25 .5 .75\nv 4 5 6\nv 7 8 9 1 0.125 .5 1\n", "a.obj", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.attributes,
            (std::vector<Attribute>{
                {"red", AttributeType::f64}, {"green", AttributeType::f64}, {"blue", AttributeType::f64}}));
  EXPECT_EQ(cell<double>(read.value(), schema, 0, 0), 0.75);
  EXPECT_EQ(cell<float>(read.value(), schema, 0, 1), 0.25f);
  EXPECT_TRUE(std::isnan(cell<double>(read.value(), schema, 1, 0))) << "no colour is not black";
  EXPECT_EQ(cell<float>(read.value(), schema, 2, 1), 0.125f) << "behind the weight";
  const auto plain = read_text("v 1 2 3\nv 4 5 6 0 0 0\n", "a.obj", schema);
  EXPECT_TRUE(plain.value().info.attributes.empty());
  EXPECT_EQ(cell<double>(plain.value(), schema, 1, 0), 0);
}

TEST(ObjReader, IsKnownByItsFirstVertexWhateverItsName) {
  for (const char* name : {"a.obj", "a.xyz", "a.las", "", "a"})
    EXPECT_EQ(read_text("# made\nmtllib a.mtl\n\no x\nv 1 2 3\nv 2 3 4\n", name).value().info.format, "obj") << name;
  EXPECT_EQ(read_text("v w z\n1 2 3\n", "a.csv").value().info.format, "xyz") << "a header";
}

TEST(ObjReader, RefusesVerticesItDoesNotUnderstand) {
  EXPECT_EQ(refusal("v 1 2\n"),
            "a.obj, line 1: has 2 numbers; a vertex has x, y and z, then a weight or nothing, then a colour of 3 "
            "numbers or nothing");
  EXPECT_NE(refusal("v 0 0 0\nv 1 2 3 4 5\n").find("a.obj, line 2: has 5 numbers"), std::string::npos);
  EXPECT_NE(refusal("v 0 0 0\nv 1 2 3 1 5 6 7 8\n").find("a.obj, line 2: has 8 numbers"), std::string::npos);
  EXPECT_EQ(refusal("v 1 2 x3\n"), "a.obj, line 1: z is 'x3', not a number");
  EXPECT_EQ(refusal("v 1 2 3 0 0 k\n"), "a.obj, line 1: blue is 'k', not a number");
  EXPECT_EQ(refusal("v 1 2 3 2\n"), "a.obj, line 1: the weight is '2'; only 1 is read");
  EXPECT_EQ(refusal("v 1 2 3 w\n"), "a.obj, line 1: the weight is 'w', not a number");
  EXPECT_EQ(refusal("# nothing\nvn 0 0 1\nf 1 2 3\n"), "a.obj: holds no points: no line begins with 'v'");
  EXPECT_EQ(sentence(read_bytes(Bytes(300), "a.obj")), "a.obj: is not text: it holds zero bytes");
}

}  // namespace
}  // namespace tessera::testing_io
