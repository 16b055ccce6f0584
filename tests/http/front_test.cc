#include "src/service/http/front.h"

#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "query.pb.h"
#include "src/service/http/secrets.h"
#include "tests/http/fake_backend.h"

namespace tessera::service::http {
namespace {

namespace fs = std::filesystem;

class FrontOf : public testing::Test {
 protected:
  FrontOf()
      : folder_(testing::TempDir() + "front-" + random_hex(8)),
        backend_(folder_, 100),
        front_(backend_.backend(), Tokens::open(folder_ / "tokens").value(), {}) {}
  ~FrontOf() override { fs::remove_all(folder_); }

  Answer ask(const std::string& method, const std::string& target, const std::string& body = {}, Headers more = {}) {
    Request request;
    request.method = method;
    request.headers = {{"host", "localhost"}, {"authorization", "Bearer " + front_.tokens().first(Role::admin)}};
    for (auto& header : more) request.headers.push_back(std::move(header));
    if (request.header("content-type").empty()) request.headers.emplace_back("content-type", "application/json");
    Admitted admitted = front_.admit(request, target, Place::api);
    request.body = body;
    Answer answer = admitted.answer ? std::move(*admitted.answer) : front_.answer(request, admitted);
    front_.complete(request, admitted, answer);
    return answer;
  }

  fs::path folder_;
  FakeBackend backend_;
  Front front_;
};

TEST_F(FrontOf, DocumentHasEveryRoute) {
  const auto document = nlohmann::json::parse(ask("GET", "/v1/api").body);
  std::set<std::string> documented, names;
  for (const auto& [path, operations] : document["paths"].items())
    for (const auto& [method, operation] : operations.items()) {
      documented.insert(method + " " + path);
      EXPECT_FALSE(operation["responses"].empty());
      names.insert(operation["operationId"]);
    }
  EXPECT_GT(front_.router().routes().size(), 25U);
  for (const Route& route : front_.router().routes()) {
    std::string method = route.method, path = route.path;
    for (char& c : method) c = static_cast<char>(std::tolower(c));
    std::erase(path, '*');
    EXPECT_EQ(documented.count(method + " " + path), 1U) << route.path;
  }
  EXPECT_EQ(documented.size(), front_.router().routes().size());
  EXPECT_EQ(names.size(), documented.size());
  // Every reference leads somewhere.
  const std::string text = document.dump();
  for (std::size_t at = text.find("#/components/"); at != std::string::npos; at = text.find("#/components/", at + 1)) {
    const std::string pointer = text.substr(at + 1, text.find('"', at) - at - 1);
    EXPECT_TRUE(document.contains(nlohmann::json::json_pointer(pointer))) << pointer;
  }
}

TEST_F(FrontOf, AWatcherHearsOfTheEndOfAJobThatEndsWhileItIsBeginningToWatch) {
  const auto body = R"({"inputs":{"triangulation":"block"}})";
  ASSERT_EQ(ask("POST", "/v1/processes/verify/execution", body).status, 201);
  backend_.before_subscribe = [&] { backend_.set_state("j1", "successful"); };
  const Answer answer = ask("GET", "/v1/jobs/j1/events");
  ASSERT_EQ(answer.status, 200);
  bool over = false;
  const std::string text = answer.events->take(over);
  EXPECT_NE(text.find("accepted"), std::string::npos) << text;
  EXPECT_NE(text.find("successful"), std::string::npos) << text;
  EXPECT_TRUE(over);
}

std::string value_of(const Answer& answer, const std::string& name) {
  for (const auto& [key, value] : answer.headers)
    if (key == name) return value;
  return {};
}

TEST_F(FrontOf, AMessageIsAnotherAnswerWithAnotherTag) {
  const std::string block = "/v1/triangulations/block/";
  const Headers wanted{{"accept", "application/x-protobuf"}};
  for (const char* path : {"locate?point=1,2", "vertices/1/star", "profile?line=0,0%201,1"}) {
    const Answer text = ask("GET", block + path), message = ask("GET", block + path, {}, wanted);
    EXPECT_EQ(value_of(text, "Content-Type"), "application/json") << path;
    EXPECT_EQ(value_of(message, "Content-Type"), "application/x-protobuf") << path;
    const std::string tag = value_of(message, "ETag");
    EXPECT_NE(tag, value_of(text, "ETag")) << path;
    for (const Answer* answer : {&text, &message}) EXPECT_EQ(value_of(*answer, "Vary"), "Accept") << path;
    Headers known{{"accept", "application/x-protobuf"}, {"if-none-match", tag}};
    const Answer same = ask("GET", block + path, {}, known);
    EXPECT_EQ(same.status, 304) << path;
    EXPECT_EQ(value_of(same, "Vary"), "Accept") << path;
    known[0].second = "application/json";
    EXPECT_EQ(ask("GET", block + path, {}, known).status, 200) << path << ": the tag is of the message";
  }
  proto::Location location;
  ASSERT_TRUE(location.ParseFromString(ask("GET", block + "locate?point=1,2", {}, wanted).body));
  EXPECT_EQ(location.point_size(), 2);
  for (const char* path : {"cells?bbox=0,0,1,1", "contours?interval=1", "shapes/hull"}) {
    const Answer file = ask("GET", block + path, {}, wanted);
    EXPECT_EQ(file.status, 200) << path;
    EXPECT_NE(value_of(file, "Content-Type"), "application/x-protobuf") << path;
    EXPECT_EQ(value_of(file, "Vary"), "") << path;
    EXPECT_EQ(value_of(file, "ETag"), value_of(ask("GET", block + path), "ETag")) << path;
  }
  const Answer wrong = ask("GET", "/v1/triangulations/none/locate?point=1,2", {}, wanted);
  EXPECT_EQ(wrong.status, 404);
  EXPECT_EQ(value_of(wrong, "Content-Type"), "application/problem+json");
}

TEST_F(FrontOf, AnswersAreMessagesAsAcceptTheBodyAndFSay) {
  struct Case {
    std::string path, type, accept;
    bool message;
  };
  const std::string json = "application/json", csv = "text/csv", pb = "application/x-protobuf";
  for (const auto& [path, type, accept, message] :
       std::vector<Case>{{"locate", json, "", false},
                         {"locate", json, pb, true},
                         {"locate", json, "*/*", false},
                         {"locate", json, json + ", " + pb + ";q=0.5", false},
                         {"locate", csv, csv + ", " + pb + ";q=0.5", false},
                         {"locate", csv, pb, true},
                         {"locate", csv, json, false},
                         {"locate?f=csv", csv, pb, false},
                         {"locate?f=json", pb, pb, false},
                         {"locate", pb, "", true},
                         {"locate", pb, "*/*", true},
                         {"locate", pb, json, false},
                         {"locate", pb + "; messageType=\"tessera.proto.Points\"", "", true},
                         {"interpolate", "application/x-npy", pb, true},
                         {"interpolate", pb, "", true},
                         {"profile", "application/geo+json", "", false},
                         {"profile", "application/geo+json", pb, true},
                         {"profile?f=geojson", "application/geo+json", pb, false},
                         {"profile", "application/geo+json", csv + ", " + pb + ";q=0.5", false},
                         {"cells", "application/geo+json", pb, false}}) {
    Headers headers{{"content-type", type}};
    if (!accept.empty()) headers.emplace_back("accept", accept);
    const Answer answer = ask("POST", "/v1/triangulations/block/" + path, "{}", headers);
    EXPECT_EQ(answer.status, 200) << path;
    EXPECT_EQ(value_of(answer, "Content-Type") == pb, message) << path << " " << type << " " << accept;
    EXPECT_EQ(value_of(answer, "Vary"), path == "cells" ? "" : "Accept") << path;
  }
  for (const char* path : {"cells", "profile"})
    EXPECT_EQ(ask("POST", std::string("/v1/triangulations/block/") + path, "", {{"content-type", pb}}).status, 415);
}

TEST_F(FrontOf, TheDocumentTellsOfMessages) {
  const auto document = nlohmann::json::parse(ask("GET", "/v1/api").body);
  const auto told = [&](const std::string& path, const std::string& method, const std::string& what) {
    const auto& operation = document["paths"]["/v1/triangulations/{triangulation}/" + path][method];
    const auto& content =
        what == "body" ? operation["requestBody"]["content"] : operation["responses"]["200"]["content"];
    return content.contains(protobuf_type) ? content[protobuf_type]["schema"]["description"].get<std::string>() : "";
  };
  const std::string message = "The message tessera.proto.";
  EXPECT_EQ(told("locate", "get", "answer"), message + "Location");
  EXPECT_EQ(told("vertices/{vertex}/star", "get", "answer"), message + "Star");
  for (const char* path : {"locate", "interpolate"}) {
    EXPECT_EQ(told(path, "post", "answer"), message + "Answers");
    EXPECT_EQ(told(path, "post", "body"), message + "Points");
  }
  for (const char* method : {"get", "post"}) {
    EXPECT_EQ(told("profile", method, "answer"), message + "Profile");
    EXPECT_EQ(told("cells", method, "answer"), "");
  }
  EXPECT_EQ(told("profile", "post", "body"), "");
}

TEST_F(FrontOf, OptionsAndWrongMethodsSayWhatIsAllowed) {
  for (const char* method : {"OPTIONS", "PATCH"}) {
    const Answer answer = ask(method, "/v1/jobs/j1");
    EXPECT_EQ(answer.status, std::string(method) == "OPTIONS" ? 204 : 405);
    EXPECT_EQ(answer.headers[0].first == "Allow" || answer.headers[1].first == "Allow" ? "yes" : "no",
              std::string("yes"));
  }
  EXPECT_EQ(ask("GET", "/v1/nothing").status, 404);
  EXPECT_EQ(ask("GET", "/metrics").status, 404) << "figures are not on the API's listener";
}

TEST_F(FrontOf, ExecutionOfWrongInputsNamesTheField) {
  const auto detail = [&](const std::string& body) {
    const Answer answer = ask("POST", "/v1/processes/triangulate/execution", body);
    EXPECT_EQ(answer.status, 400) << body;
    const auto problem = nlohmann::json::parse(answer.body);
    EXPECT_EQ(problem["cause"], 2) << body;
    return problem["detail"].get<std::string>();
  };
  EXPECT_NE(detail(R"({"inputs":{"inputs":["a"],"tile_point":5}})").find("tile_point"), std::string::npos);
  EXPECT_NE(detail(R"({"inputs":{"inputs":["a"],"tiles":"x"}})").find("tiles"), std::string::npos);
  EXPECT_NE(detail(R"({"inputs":{"inputs":["a"]},"subscriber":{}})").find("subscriber"), std::string::npos);
  EXPECT_NE(detail(R"({})").find("inputs"), std::string::npos);
  EXPECT_NE(detail(R"([1])").find("object"), std::string::npos);
  EXPECT_NE(detail("{").find("JSON"), std::string::npos);
  EXPECT_NE(detail(std::string(500'000, '[')).find("nested"), std::string::npos);
  EXPECT_NE(detail(R"({"inputs":)" + std::string(100, '[') + std::string(100, ']') + "}").find("nested"),
            std::string::npos);
}

// Whatever comes: an answer that is one, never an exception, never 500.
TEST_F(FrontOf, AnswersMutatedRequests) {
  std::mt19937 random(12);
  const std::string body = R"({"inputs":{"inputs":["a.las"],"tiles":5,"crop":[0,0,0,1,1,1],"memory":"4G"}})";
  const char* targets[] = {"/v1/jobs?limit=5&status=running", "/v1/processes/triangulate/execution",
                           "/v1/triangulations/block/files/deep/tile.vtu", "/v1/processes/triangulate/estimate"};
  const auto mutated = [&](std::string text) {
    for (std::size_t times = random() % 4; times > 0 && !text.empty(); --times) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, random() % 5);
      else if (random() % 2 == 0)
        text.insert(at, text.substr(random() % text.size(), random() % 9));
      else
        text[at] = static_cast<char>(random());
    }
    return text;
  };
  std::map<int, int> statuses;
  for (int round = 0; round < 20'000; ++round) {
    const Answer answer = ask(random() % 2 ? "POST" : "GET", mutated(targets[random() % 4]), mutated(body),
                              {{"range", mutated("bytes=3-50")}, {"last-event-id", mutated("17")}});
    ++statuses[answer.status];
    ASSERT_NE(answer.status, 500);
    ASSERT_NE(reason_phrase(answer.status), "Status") << answer.status;
  }
  for (const int expected : {200, 201, 206, 400, 404, 405}) EXPECT_GT(statuses[expected], 20) << expected;
}

class LoneNode final : public NodeHealth {
 public:
  NodeFigures figures() const override {
    NodeFigures told;
    told.member = !trouble;
    told.bytes_sent = sent;
    return told;
  }
  std::optional<std::string> unready() const override { return trouble; }
  std::optional<std::string> trouble;
  std::uint64_t sent = 7;
};

TEST(NodeFront, HasHealthAndFiguresWithoutATokenAndNothingElse) {
  LoneNode node;
  Front front(node);
  const auto ask = [&](const std::string& target, Place place = Place::operations) {
    Request request;
    request.method = "GET";
    request.headers = {{"host", "10.1.0.7:7071"}};
    Admitted admitted = front.admit(request, target, place);
    Answer answer = admitted.answer ? std::move(*admitted.answer) : front.answer(request, admitted);
    front.complete(request, admitted, answer);
    return answer;
  };
  EXPECT_EQ(ask("/livez").status, 200);
  EXPECT_EQ(ask("/readyz?verbose").body, "[+] node\n[+] http\nready\n");
  EXPECT_NE(ask("/metrics").body.find("tessera_node_bytes_total 7\n"), std::string::npos);
  node.trouble = "looks for a coordinator";
  node.sent = 9;
  EXPECT_EQ(ask("/readyz").status, 503);
  EXPECT_EQ(ask("/readyz?verbose").body, "[-] node: looks for a coordinator\nnot ready\n");
  const std::string figures = ask("/metrics").body;
  EXPECT_NE(figures.find("tessera_node_bytes_total 9\n"), std::string::npos);
  EXPECT_NE(figures.find("tessera_member 0\n"), std::string::npos);
  for (const char* target : {"/", "/v1/jobs", "/v1", "/ui/"}) EXPECT_EQ(ask(target).status, 404) << target;
}

}  // namespace
}  // namespace tessera::service::http
