// A node of a cluster that knows the jobs of greatest_on_disk.h. Its arguments: name, port to listen at, port of the
// coordinator, folder of certificates, scratch folder. It ends when it is killed, or its input ends.
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/base/files/names.h"
#include "tests/cluster/greatest_on_disk.h"

int main(int argc, char** argv) {
  using namespace tessera;
  if (argc != 6) return 2;
  const auto port = [](const char* text) { return static_cast<std::uint16_t>(std::stoul(text)); };
  const std::filesystem::path certs = argv[4];
  ClusterOptions options;
  options.node_name = argv[1];
  options.listen = {"127.0.0.1", port(argv[2])};
  options.coordinator = false;
  options.join = {{"127.0.0.1", port(argv[3])}};
  options.authority = authority_file(certs);
  options.certificate = node_certificate_file(certs, "all");
  options.key = node_key_file(certs, "all");
  options.scratch = argv[5];
  const auto engine = Engine::join(
      1, std::uint64_t{256} << 20, std::make_unique<Seat>(std::move(options)),
      {{testing::kind_of_greatest, std::make_shared<const testing::GreatestOnDisk>(std::string(argv[1]))}});
  if (!engine) {
    std::cerr << engine.error().where << '\n';
    return 1;
  }
  while (std::getchar() != EOF) {
  }
  return 0;
}
