// Lists of options in the form that GDAL takes.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tessera::terrain {

// A list of "NAME=VALUE", or of words of a command line.
class Choices {
 public:
  explicit Choices(std::vector<std::string> texts) : texts_(std::move(texts)) {
    for (auto& text : texts_) pointers_.push_back(text.data());
    pointers_.push_back(nullptr);
  }
  char** get() { return pointers_.data(); }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
};

}  // namespace tessera::terrain
