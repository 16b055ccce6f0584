// Requests that are sent again while another try may get a better answer.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/input/remote/transfers.h"

namespace tessera::remote {

inline constexpr int tries_max = 5;

// Sends requests until each has an answer that another try would not better, with growing waits between the tries.
// Errors: interrupted; `name` is what is asked about.
Result<std::vector<HttpReply>> persistently(Transfers& transfers, const std::vector<HttpRequest>& requests,
                                            const std::string& name, const std::stop_token& stop);

// A header of an answer; empty when there is none. `name` is in lower case.
const std::string& header(const HttpReply& reply, const char* name);

// The reason that a store of objects gives: "NoSuchKey"; or empty.
std::string code_of_store(const HttpReply& reply);

// What an answer without bytes for the caller means. `write`: the request wanted to write the object.
std::string sentence_of_status(const HttpReply& reply, bool write = false);

// When an answer says that the bucket is in another region, turns the request into one for that region. Returns whether
// it did.
bool turn_to_other_region(HttpRequest& request, const HttpReply& reply);

// A decimal number and nothing else.
std::optional<std::uint64_t> number_of(std::string_view text);

}  // namespace tessera::remote
