// A temporary folder for a test, and what a fault does to a file in it.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"

namespace tessera {

inline BigVector<std::byte> to_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// Calls `check` with a name for each fault, while the file has it: every bit flipped, every truncation, a byte more.
template <class Check>
void for_each_damage(const std::filesystem::path& path, Check check) {
  const auto whole = read_whole(path).value();
  // Not synced: there are hundreds.
  const auto write = [&](const std::vector<std::byte>& bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  const auto with = [&](const std::vector<std::byte>& damaged, const std::string& name) {
    write(damaged);
    check(name);
  };
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    auto damaged = whole;
    damaged[bit / 8] ^= std::byte{1} << (bit % 8);
    with(damaged, "bit " + std::to_string(bit));
  }
  for (std::size_t size = 0; size < whole.size(); ++size)
    with({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}, "cut to " + std::to_string(size));
  auto longer = whole;
  longer.push_back(std::byte{0});
  with(longer, "a byte more");
  write(whole);
}

class FolderFixture : public testing::Test {
 protected:
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  TemporaryFolder folder_ = TemporaryFolder::make().value();
};

}  // namespace tessera
