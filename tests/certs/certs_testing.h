// A folder of its own for each test, and the program openssl to see the files as others do.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "src/base/files/temporary.h"
#include "src/cluster/certs/certificates.h"

namespace tessera {

class Certificates : public testing::Test {
 protected:
  static constexpr std::chrono::days day{1};

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path file(const std::string& name) const { return folder() / name; }
  Status check(const std::string& node) const {
    return check_node(file("ca.pem"), file(node + ".pem"), file(node + ".key"));
  }
  static CertificateOptions made(std::chrono::days from_now) {
    CertificateOptions options;
    options.now += from_now;
    return options;
  }
  // What the program says, and "exit N" when it fails. `arguments`: for a shell in the folder.
  std::string openssl(const std::string& arguments) const {
    const std::string line = "(cd '" + folder().string() + "' && openssl " + arguments + ") 2>&1 || echo exit $?";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> program(::popen(line.c_str(), "r"), ::pclose);
    std::string said;
    std::array<char, 4096> part{};
    for (std::size_t got = 1; program && (got = std::fread(part.data(), 1, part.size(), program.get())) > 0;)
      said.append(part.data(), got);
    return said;
  }
  // The last three digits, in octal.
  static int rights(const std::filesystem::path& path) {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? static_cast<int>(status.st_mode & 0777U) : -1;
  }

 private:
  TemporaryFolder folder_ = TemporaryFolder::make().value();
};

// `sentence` is how it ends, after the folder.
inline void expect_refused(const Status& status, Errc code, const std::string& sentence) {
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, code);
  EXPECT_NE(status.error().where.find(sentence), std::string::npos) << status.error().where;
}

}  // namespace tessera
