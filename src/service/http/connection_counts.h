// How many connections a listener has, and how many of them an address: strangers cannot take them all.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

namespace tessera::http {

// Of addresses that are one network's of a single user (IPv6: the first 64 bits) one name; of IPv4 in IPv6 its own.
std::string group_of(const boost::asio::ip::address& address);

// Safe from any thread.
class ConnectionCounts {
 public:
  // `most`: in all; half of them, but at least 8, from one address.
  explicit ConnectionCounts(std::uint32_t most);
  // False when there are too many.
  bool take(const std::string& group);
  void give_back(const std::string& group);

 private:
  const std::uint32_t most_, of_a_group_;
  std::mutex mutex_;
  std::uint32_t count_ = 0;
  std::unordered_map<std::string, std::uint32_t> groups_;
};

// How many connections fit into the limit of open files when each sends a file and half of the limit is left to jobs:
// at most `wanted`.
std::uint32_t connections_within(std::uint64_t open_files, std::uint32_t wanted);

}  // namespace tessera::http
