// What the made-up service answers to questions, and lists.
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>

#include "query.pb.h"
#include "tests/http/fake_backend.h"

namespace tessera::service {
namespace {

proto::Problem missing(const char* detail) {
  proto::Problem problem;
  problem.set_status(404);
  problem.set_detail(detail);
  return problem;
}

// As empty as a message may be.
QuestionAnswer in_message(const Question& question) {
  using About = Question::About;
  const auto told = [](const auto& message) {
    return QuestionAnswer{.text = message.SerializeAsString(), .type = protobuf_type};
  };
  if (question.about == About::profile) return told(proto::Profile());
  if (question.body) {
    proto::Answers answers;
    answers.add_answers()->set_value(3);
    return told(answers);
  }
  if (question.about == About::locate) {
    proto::Location location;
    location.add_point(1);
    location.add_point(2);
    return told(location);
  }
  proto::Star star;
  star.set_asked(1);
  return told(star);
}

}  // namespace

Reply<QuestionAnswer> FakeBackend::ask(const Question& question) {
  using About = Question::About;
  if (question.as_message) return in_message(question);
  const auto type = [&]() -> std::string {
    switch (question.about) {
      case About::cells:
      case About::contours:
        return "application/geo+json";
      case About::dem:
        return "image/tiff; application=geotiff; profile=cloud-optimized";
      case About::hull:
      case About::section:
      case About::solids:
        return "model/gltf-binary";
      default:
        return {};
    }
  }();
  if (!type.empty()) {
    auto opened = open(folder_ / "block" / "deep" / "tile.vtu", type.c_str(), "");
    if (!opened) return opened.error();
    return QuestionAnswer{.text = {}, .file = opened.value()};
  }
  if (question.about == Question::About::star && question.vertex == "13") {
    std::unique_lock lock(mutex_);
    return give_up(lock, question.stop);
  }
  std::string text = R"({"point":[1,2],"cell":null})";
  if (question.about == Question::About::star)
    text =
        R"({"asked":1,"vertex":{"id":1,"tile":0,"point":[1,2]},"voronoi_volume":null,"on_hull":true,"neighbors":[],"cells":[]})";
  if (question.about == About::neighbours) text = R"({"asked":1,"vertex":1,"on_hull":true,"neighbors":[2]})";
  if (question.about == About::map_tile) return QuestionAnswer{.text = "png", .type = "image/png"};
  if (question.about == About::features) {
    const std::string feature =
        R"({"type":"Feature","id":7,"properties":{},"geometry":{"type":"Polygon","coordinates":[[[2,48],[3,48],[2,49],[2,48]]]})";
    if (const auto item = question.options.find("item"); item != question.options.end())
      return QuestionAnswer{.text = item->second == "7" ? feature : "", .type = "application/geo+json"};
    QuestionAnswer page{.text = R"({"type":"FeatureCollection","numberReturned":1,"features":[)" + feature + "}]",
                        .type = "application/geo+json"};
    if (!question.options.contains("after")) page.next = 1;
    return page;
  }
  if (question.about == Question::About::profile) {
    std::string profile = R"({"points":[{"distance":0,"x":1,"y":2,"z":3,"part":0}]})";
    if (profile.size() < profile_bytes) profile.resize(profile_bytes, ' ');
    return QuestionAnswer{.text = std::move(profile), .type = "application/json"};
  }
  if (question.body) text = R"({"answers":[{"point":[1,2],"value":3}]})";
  return QuestionAnswer{.text = text, .type = "application/json"};
}

proto::Problem FakeBackend::give_up(std::unique_lock<std::mutex>& lock, const std::stop_token& stop) {
  std::condition_variable_any never;
  ++asked_;
  held_changed_.notify_all();
  never.wait(lock, stop, [] { return false; });
  --asked_;
  ++given_up_;
  held_changed_.notify_all();
  proto::Problem gone = missing("nobody waits for it");
  gone.set_status(410);
  return gone;
}

Reply<std::vector<FeatureCollection>> FakeBackend::collections() {
  return std::vector<FeatureCollection>{collection("block.tiles").value()};
}

Reply<FeatureCollection> FakeBackend::collection(std::string_view id) {
  if (id != "block.tiles") return missing("there is no such collection");
  return FeatureCollection{.id = "block.tiles",
                           .triangulation = "block",
                           .kind = "tiles",
                           .title = "block: tiles",
                           .description = "",
                           .extent = {2, 48, 3, 49},
                           .storage_crs = "http://www.opengis.net/def/crs/EPSG/0/2154"};
}

Reply<std::array<double, 4>> FakeBackend::map_extent(std::string_view name) {
  if (name != "block") return missing("there is no map");
  return std::array<double, 4>{2, 48, 3, 49};
}

Reply<proto::ExportList> FakeBackend::exports(std::string_view name, std::uint32_t, std::string_view) {
  if (name != "block") return missing("there is no such triangulation");
  proto::ExportList list;
  proto::ExportInfo& mesh = *list.add_exports();
  mesh.set_name("mesh.ply");
  mesh.set_bytes(7);
  mesh.set_files(1);
  list.set_number_matched(1);
  return list;
}

Reply<proto::InputList> FakeBackend::list(std::string_view folder, std::uint32_t, std::string_view, const Caller&) {
  proto::InputList list;
  list.set_folder(std::string(folder));
  list.set_number_matched(0);
  return list;
}

}  // namespace tessera::service
