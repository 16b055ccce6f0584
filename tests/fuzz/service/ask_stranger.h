// What the fuzz targets of the service do with a stranger's bytes, and the replay test with those of earlier runs.
#pragma once

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/files/temporary.h"
#include "src/base/point.h"
#include "src/service/http/front.h"
#include "src/service/http/head.h"
#include "src/service/http/processes.h"
#include "src/service/http/ranges.h"
#include "src/service/http/target.h"
#include "src/service/http/tokens.h"
#include "src/service/json.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/table.h"
#include "src/service/questions/answer_messages.h"
#include "tests/http/fake_backend.h"

namespace tessera::service {

inline void must(bool holds) {
  if (!holds) std::abort();
}

// A front end without sockets. Jobs pile up in its service: it is made anew from time to time.
class StrangersFront {
 public:
  static constexpr std::string_view token = "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa";

  http::Front& front() {
    if (!front_ || ++asked_ % 4096 == 0) {
      front_.reset();
      backend_ = std::make_unique<FakeBackend>(folder_.path(), 1000);
      front_ = std::make_unique<http::Front>(backend_->backend(), tokens(), http::FrontOptions{});
    }
    return *front_;
  }

 private:
  static TemporaryFolder made() {
    auto folder = TemporaryFolder::make();
    must(folder.has_value());
    return std::move(folder).value();
  }
  // One line, as a file that its owner alone reads.
  http::Tokens tokens() const {
    auto opened = http::Tokens::open(folder_.path() / "tokens");
    must(opened.has_value());
    return std::move(opened).value();
  }

  const TemporaryFolder folder_ = made();
  std::unique_ptr<FakeBackend> backend_;
  std::unique_ptr<http::Front> front_;
  std::uint64_t asked_ = 0;
};

// An answer is HTTP that Beast itself understands, and a problem is one in JSON.
inline void check_answer(const http::Answer& answer) {
  namespace beast = boost::beast;
  must(answer.status >= 200 && answer.status < 600 && answer.status != 500);
  const std::string head = http::head_of(answer, true);
  beast::http::response_parser<beast::http::empty_body> parser;
  parser.skip(true);
  beast::error_code failed;
  must(parser.put(boost::asio::buffer(head), failed) == head.size() && !failed);
  if (!answer.problem) return;
  const auto told = nlohmann::json::parse(answer.body, nullptr, false);
  must(told.is_object() && told["status"] == answer.status && told["detail"].is_string());
}

// As a session does with what comes from a socket.
inline void ask_stranger(StrangersFront& strangers, std::string_view bytes) {
  namespace beast = boost::beast;
  http::Front& front = strangers.front();
  beast::http::request_parser<beast::http::string_body> parser;
  parser.eager(true);
  parser.header_limit(8 << 10);
  parser.body_limit(1 << 20);
  beast::error_code failed;
  parser.put(boost::asio::buffer(bytes.data(), bytes.size()), failed);
  if (!parser.is_header_done()) return;
  const auto& message = parser.get();
  http::Request request;
  request.method = std::string(message.method_string());
  for (const auto& field : message) {
    std::string name(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    // A fuzzer does not guess tokens: any that is shown is the right one.
    const bool shown = name == "authorization" && field.value().starts_with("Bearer ");
    request.headers.emplace_back(std::move(name),
                                 shown ? "Bearer " + front.tokens().first(Role::admin) : std::string(field.value()));
  }
  request.body = message.body();
  const std::string_view target(message.target().data(), message.target().size());
  for (const auto place : {http::Place::api, http::Place::operations}) {
    auto admitted = front.admit(request, target, place);
    const bool answered = admitted.answer.has_value();
    if (!answered && admitted.route->upload) continue;
    http::Answer answer = answered ? std::move(*admitted.answer) : front.answer(request, admitted);
    front.complete(request, admitted, answer);
    check_answer(answer);
  }
  // What was decoded and is encoded again is the same address.
  if (const auto parsed = http::parse_target(target)) {
    std::string again = parsed.value().segments.empty() ? "/" : "";
    for (const auto& segment : parsed.value().segments) again += "/" + http::encode_segment(segment);
    const auto twice = http::parse_target(again);
    must(twice && twice.value().segments == parsed.value().segments);
  }
  for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{1000}, ~std::uint64_t{0}}) {
    const auto found = http::find_range(request.header("range"), size);
    if (found.kind == http::RangeKind::part)
      must(found.range.bytes > 0 && found.range.offset < size && found.range.bytes <= size - found.range.offset);
  }
}

// The bytes as what each process is asked, down to the engine's options, and as points.
inline void take_inputs(std::string_view bytes) {
  for (const int dimension : {2, 3}) {
    const auto points = points_of(bytes, dimension);
    must(points ? std::all_of(points.value().begin(), points.value().end(), is_finite) : !points.error().where.empty());
  }
  const JobShare share{2, std::uint64_t{1} << 30};
  for (const Process* process : all_processes()) {
    for (const char* type : {"application/json", "application/x-protobuf"}) {
      http::Request request;
      request.headers.emplace_back("content-type", type);
      request.body = bytes;
      const auto inputs = http::read_inputs(*process, request);
      if (!inputs) {
        must(!inputs.error().where.empty());
        continue;
      }
      if (std::string_view(type) == "application/json") {
        proto::Inputs again;
        must(from_json(to_json(inputs.value()), again) &&
             again.SerializeAsString() == inputs.value().SerializeAsString());
      }
      const auto sentence = [](const auto& options) { must(options || !options.error().where.empty()); };
      if (inputs.value().has_triangulate()) sentence(job_options(inputs.value().triangulate(), share));
      if (inputs.value().has_verify()) sentence(verify_options(inputs.value().verify(), share));
      if (inputs.value().has_export_()) sentence(export_options(inputs.value().export_()));
      if (inputs.value().has_info()) {
        if (const auto cloud = cloud_of(inputs.value().info())) sentence(job_options(cloud.value(), share));
      }
    }
  }
}

}  // namespace tessera::service
