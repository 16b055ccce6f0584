#include "src/service/http/connection_counts.h"

#include <algorithm>

namespace tessera::service::http {
namespace {

constexpr std::uint32_t of_a_group_min = 8, connections_min = 8;

}  // namespace

std::string group_of(const boost::asio::ip::address& address) {
  namespace ip = boost::asio::ip;
  if (address.is_v4()) return address.to_string();
  const ip::address_v6 six = address.to_v6();
  if (six.is_v4_mapped()) return ip::make_address_v4(ip::v4_mapped, six).to_string();
  ip::address_v6::bytes_type bytes = six.to_bytes();
  std::fill(bytes.begin() + bytes.size() / 2, bytes.end(), 0);
  return ip::address_v6(bytes).to_string() + "/64";
}

ConnectionCounts::ConnectionCounts(std::uint32_t most) : most_(most), of_a_group_(std::max(of_a_group_min, most / 2)) {}

bool ConnectionCounts::take(const std::string& group) {
  const std::scoped_lock lock(mutex_);
  if (count_ >= most_) return false;
  std::uint32_t& of_group = groups_[group];
  if (of_group >= of_a_group_) return false;
  ++of_group;
  ++count_;
  return true;
}

void ConnectionCounts::give_back(const std::string& group) {
  const std::scoped_lock lock(mutex_);
  --count_;
  const auto found = groups_.find(group);
  if (--found->second == 0) groups_.erase(found);
}

std::uint32_t connections_within(std::uint64_t open_files, std::uint32_t wanted) {
  const std::uint64_t fit = std::max<std::uint64_t>(connections_min, open_files / 4);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(fit, wanted));
}

}  // namespace tessera::service::http
