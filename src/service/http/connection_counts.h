// Counts the connections of a listener, in all and from each address, so that one client cannot take them all.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

namespace tessera::service::http {

// The group of an address. IPv6 addresses of one user's network (the same first 64 bits) have the same group. An IPv4
// address in IPv6 form has the group of the IPv4 address.
std::string group_of(const boost::asio::ip::address& address);

// Thread-safe.
class ConnectionCounts {
 public:
  // Allows `most` connections in all, and half of them, but at least 8, from one group.
  explicit ConnectionCounts(std::uint32_t most);
  // Returns false when there are too many.
  bool take(const std::string& group);
  void give_back(const std::string& group);

 private:
  const std::uint32_t most_, of_a_group_;
  std::mutex mutex_;
  std::uint32_t count_ = 0;
  std::unordered_map<std::string, std::uint32_t> groups_;
};

// The number of connections, at most `wanted`, that fit into the limit of open files when each sends a file and half of
// the limit is left to jobs.
std::uint32_t connections_within(std::uint64_t open_files, std::uint32_t wanted);

}  // namespace tessera::service::http
