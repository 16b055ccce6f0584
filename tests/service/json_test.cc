#include "src/service/json.h"

#include <gtest/gtest.h>

#include "service.pb.h"

namespace tessera::service {
namespace {

std::string refusal(std::string_view json) {
  proto::TriangulateInputs inputs;
  const auto read = from_json(json, inputs);
  return read ? "" : read.error().where;
}

TEST(Json, NumbersOf64BitsAreNumbersAndNothingOfThemIsLost) {
  proto::Estimate estimate;
  estimate.set_points(~std::uint64_t{0});
  EXPECT_NE(to_json(estimate).find(R"("points":18446744073709551615,)"), std::string::npos);
  proto::Estimate back;
  ASSERT_TRUE(from_json(to_json(estimate), back));
  EXPECT_EQ(back.points(), ~std::uint64_t{0});
}

TEST(Json, FieldsHaveTheNamesOfTheProtoFileOrTheirOwn) {
  proto::StatusInfo status;
  status.set_job_id("7");
  status.set_eta_s(1.5);
  proto::TriangulateInputs inputs;
  inputs.set_skip_invalid(false);
  const auto text = to_json(status);
  EXPECT_NE(text.find(R"("jobID":"7")"), std::string::npos) << text;
  EXPECT_NE(text.find(R"("eta":1.5)"), std::string::npos) << text;
  EXPECT_NE(to_json(inputs).find(R"("skip_invalid":false)"), std::string::npos) << to_json(inputs);
}

TEST(Json, WhatIsNotThereIsLeftOutButListsAndNumbers) {
  EXPECT_EQ(to_json(proto::JobList()), R"({"jobs":[],"links":[],"numberMatched":0})");
  EXPECT_EQ(to_json(proto::Problem()), R"({"status":0,"cause":0})");
}

TEST(Json, WhatIsWrittenIsReadBack) {
  proto::Inputs inputs;
  auto& triangulate = *inputs.mutable_triangulate();
  triangulate.add_inputs("a \"b\" \\ \x01 é.laz");
  triangulate.add_crop(0.1);
  triangulate.add_crop(-1e300);
  triangulate.add_class_(2);
  triangulate.set_memory("4G");
  triangulate.set_dim(0);
  proto::Inputs back;
  const auto read = from_json(to_json(inputs), back);
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_EQ(back.SerializeAsString(), inputs.SerializeAsString());
}

TEST(Json, NamesMayBeInCamelCaseAndNullIsNothing) {
  proto::TriangulateInputs inputs;
  ASSERT_TRUE(from_json(R"({"tilePoints": "12", "dim": null, "threads": 3})", inputs));
  EXPECT_EQ(inputs.tile_points(), 12);
  EXPECT_FALSE(inputs.has_dim());
  EXPECT_EQ(inputs.threads(), 3);
}

TEST(Json, RefusalsNameTheField) {
  EXPECT_EQ(refusal(R"({"treads": 1})"), "'treads' is not a known field");
  EXPECT_EQ(refusal(R"({"threads": -1})"), "threads is not a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal(R"({"threads": 1.5})"), "threads is not a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal(R"({"threads": 4294967296})"), "threads is not a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal(R"({"threads": "1"})"), "threads is not a whole number from 0 to 4294967295");
  EXPECT_EQ(refusal(R"({"crop": [1, "2"]})"), "crop[1] is not a finite number");
  EXPECT_EQ(refusal(R"({"crop": 1})"), "crop is not a list in brackets");
  EXPECT_EQ(refusal(R"({"memory": 4})"), "memory is not a text");
  EXPECT_EQ(refusal(R"({"recursive": 1})"), "recursive is neither true nor false");
  EXPECT_EQ(refusal("[]"), "the JSON text is not an object in braces");
  EXPECT_EQ(refusal(R"({"tile_points": 1, "tilePoints": 2})"),
            "tile_points is given twice, or together with a field that excludes it");
  proto::Inputs inputs;
  EXPECT_FALSE(from_json(R"({"verify": {}, "info": {}})", inputs));
  const auto nested = from_json(R"({"triangulate": {"inputs": ["a", 2]}})", inputs);
  EXPECT_EQ(nested.error().where, "triangulate.inputs[1] is not a text");
}

TEST(Json, TextThatIsNoJsonIsRefused) {
  for (const auto* text : {"", "{", "{}x", "{\"a\"", "nul", "{\"memory\": \"\xff\"}", "{\"crop\": [1e999]}", "\xff"}) {
    proto::TriangulateInputs inputs;
    const auto read = from_json(text, inputs);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, Errc::usage);
    EXPECT_EQ(as_utf8(read.error().where), read.error().where);
  }
}

TEST(Json, DeepNestingIsRefusedBeforeItIsRead) {
  for (const auto* open : {"[", "{\"a\":", "[{\"a\":"}) {
    std::string deep;
    for (int i = 0; i < 300'000; ++i) deep += open;
    EXPECT_NE(refusal(deep).find("nested more than 32 deep"), std::string::npos);
  }
  // Brackets in texts nest nothing.
  EXPECT_EQ(refusal(R"({"memory": ")" + std::string(100, '[') + R"(\"[["})"), "");
}

// With a look at all keys for each it would take hours.
TEST(Json, TakesNoLongerForManyKeysThanForManyValues) {
  std::string many = "{";
  for (int i = 0; i < 2'000'000; ++i) many += "\"key" + std::to_string(i) + "\":0,";
  EXPECT_EQ(refusal(many + "\"a\":0}"), "'a' is not a known field");
}

TEST(Json, BytesThatAreNoUtf8AreReplaced) {
  EXPECT_EQ(as_utf8("a\xff\xc3\xa9\xc3"), "a\xEF\xBF\xBD\xC3\xA9\xEF\xBF\xBD");
}

}  // namespace
}  // namespace tessera::service
