#include "src/service/json.h"

#include <google/protobuf/descriptor.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "src/base/utf8.h"

namespace tessera::service {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Json = nlohmann::json;  // sorted: the ordered type searches all keys for each new one
using Type = FieldDescriptor::CppType;

constexpr int nested_max = 32;

// Writes text directly from the message: a tree in between takes several times as long as all the rest.
class Writer {
 public:
  void write(const Message& message) {
    const Descriptor& type = *message.GetDescriptor();
    const Reflection& of = *message.GetReflection();
    text_ += '{';
    bool first = true;
    for (int i = 0; i < type.field_count(); ++i) {
      const FieldDescriptor& field = *type.field(i);
      const bool list = field.is_repeated();
      const bool may_lack = field.has_presence() || field.cpp_type() == Type::CPPTYPE_STRING;
      if (!list && may_lack && !of.HasField(message, &field)) continue;
      if (!std::exchange(first, false)) text_ += ',';
      write(field.has_json_name() ? field.json_name() : field.name());
      text_ += ':';
      if (!list) {
        write(message, of, field, -1);
        continue;
      }
      text_ += '[';
      for (int at = 0; at < of.FieldSize(message, &field); ++at) {
        if (at > 0) text_ += ',';
        write(message, of, field, at);
      }
      text_ += ']';
    }
    text_ += '}';
  }
  std::string take() { return std::move(text_); }

 private:
  // `at` is the index in a list; -1 for a field that is not repeated.
  void write(const Message& message, const Reflection& of, const FieldDescriptor& field, int at) {
    const bool list = at >= 0;
    switch (field.cpp_type()) {
      case Type::CPPTYPE_INT32:
        return write_number(list ? of.GetRepeatedInt32(message, &field, at) : of.GetInt32(message, &field));
      case Type::CPPTYPE_INT64:
        return write_number(list ? of.GetRepeatedInt64(message, &field, at) : of.GetInt64(message, &field));
      case Type::CPPTYPE_UINT32:
        return write_number(list ? of.GetRepeatedUInt32(message, &field, at) : of.GetUInt32(message, &field));
      case Type::CPPTYPE_UINT64:
        return write_number(list ? of.GetRepeatedUInt64(message, &field, at) : of.GetUInt64(message, &field));
      case Type::CPPTYPE_DOUBLE:
        return write_real(list ? of.GetRepeatedDouble(message, &field, at) : of.GetDouble(message, &field));
      case Type::CPPTYPE_FLOAT:
        return write_real(list ? of.GetRepeatedFloat(message, &field, at) : of.GetFloat(message, &field));
      case Type::CPPTYPE_BOOL:
        text_ += (list ? of.GetRepeatedBool(message, &field, at) : of.GetBool(message, &field)) ? "true" : "false";
        return;
      case Type::CPPTYPE_ENUM:
        return write((list ? of.GetRepeatedEnum(message, &field, at) : of.GetEnum(message, &field))->name());
      case Type::CPPTYPE_STRING: {
        std::string scratch;
        return write(list ? of.GetRepeatedStringReference(message, &field, at, &scratch)
                          : of.GetStringReference(message, &field, &scratch));
      }
      case Type::CPPTYPE_MESSAGE:
        return write(list ? of.GetRepeatedMessage(message, &field, at) : of.GetMessage(message, &field));
    }
  }

  template <class Number>
  void write_number(Number number) {
    char digits[32];
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  }

  // The shortest digits that are read back as the same number; null for a number that is not finite.
  template <class Real>
  void write_real(Real number) {
    if (!std::isfinite(number)) {
      text_ += "null";
      return;
    }
    const std::size_t begin = text_.size();
    write_number(number);
    if (text_.find_first_of(".e", begin) == std::string::npos) text_ += ".0";
  }

  void write(const std::string& value) {
    constexpr char hex[] = "0123456789abcdef";
    text_ += '"';
    for (const char c : is_utf8(value) ? value : as_utf8(value)) {
      if (c == '"' || c == '\\') {
        text_ += '\\';
        text_ += c;
      } else if (static_cast<unsigned char>(c) >= 0x20) {
        text_ += c;
      } else {
        text_ += "\\u00";
        text_ += hex[c >> 4];
        text_ += hex[c & 15];
      }
    }
    text_ += '"';
  }

  std::string text_;
};

const FieldDescriptor* field_named(const Descriptor& type, const std::string& name) {
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    if (name == field->name() || name == field->json_name()) return field;
  }
  return nullptr;
}

Error wrong(const std::string& place, const std::string& reason) {
  return error(Errc::usage, (place.empty() ? "the JSON text" : place) + " " + reason);
}

template <class Number>
std::optional<Number> whole_number(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    if (number > static_cast<std::uint64_t>(std::numeric_limits<Number>::max())) return std::nullopt;
    return static_cast<Number>(number);
  }
  if (value.is_number_integer()) {
    const auto number = value.get<std::int64_t>();  // negative
    if (std::is_unsigned_v<Number> || number < static_cast<std::int64_t>(std::numeric_limits<Number>::min()))
      return std::nullopt;
    return static_cast<Number>(number);
  }
  if (value.is_string() && sizeof(Number) == 8) {
    const auto& text = value.get_ref<const std::string&>();
    Number number = 0;
    const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (!text.empty() && ec == std::errc{} && end == text.data() + text.size()) return number;
  }
  return std::nullopt;
}

Status read_object(const Json& json, const std::string& place, Message& message);

template <class Number, class Set>
Status read_whole_number(const Json& value, const std::string& place, const Set& set) {
  const auto number = whole_number<Number>(value);
  if (!number) {
    return wrong(place, "is not a whole number from " + std::to_string(std::numeric_limits<Number>::min()) + " to " +
                            std::to_string(std::numeric_limits<Number>::max()));
  }
  set(*number);
  return success();
}

// Sets the field, or appends to it if it is repeated.
Status read_value(const Json& value, const std::string& place, const FieldDescriptor& field, Message& message) {
  const Reflection& of = *message.GetReflection();
  const bool list = field.is_repeated();
  switch (field.cpp_type()) {
    case Type::CPPTYPE_INT32:
      return read_whole_number<std::int32_t>(value, place, [&](std::int32_t number) {
        list ? of.AddInt32(&message, &field, number) : of.SetInt32(&message, &field, number);
      });
    case Type::CPPTYPE_INT64:
      return read_whole_number<std::int64_t>(value, place, [&](std::int64_t number) {
        list ? of.AddInt64(&message, &field, number) : of.SetInt64(&message, &field, number);
      });
    case Type::CPPTYPE_UINT32:
      return read_whole_number<std::uint32_t>(value, place, [&](std::uint32_t number) {
        list ? of.AddUInt32(&message, &field, number) : of.SetUInt32(&message, &field, number);
      });
    case Type::CPPTYPE_UINT64:
      return read_whole_number<std::uint64_t>(value, place, [&](std::uint64_t number) {
        list ? of.AddUInt64(&message, &field, number) : of.SetUInt64(&message, &field, number);
      });
    case Type::CPPTYPE_DOUBLE:
    case Type::CPPTYPE_FLOAT: {
      if (!value.is_number() || !std::isfinite(value.get<double>())) return wrong(place, "is not a finite number");
      const auto number = value.get<double>();
      if (field.cpp_type() == Type::CPPTYPE_DOUBLE) {
        list ? of.AddDouble(&message, &field, number) : of.SetDouble(&message, &field, number);
      } else {
        const auto narrow = static_cast<float>(number);
        list ? of.AddFloat(&message, &field, narrow) : of.SetFloat(&message, &field, narrow);
      }
      return success();
    }
    case Type::CPPTYPE_BOOL:
      if (!value.is_boolean()) return wrong(place, "is neither true nor false");
      list ? of.AddBool(&message, &field, value.get<bool>()) : of.SetBool(&message, &field, value.get<bool>());
      return success();
    case Type::CPPTYPE_ENUM: {
      const auto* known = value.is_string() ? field.enum_type()->FindValueByName(value.get<std::string>()) : nullptr;
      if (known == nullptr) return wrong(place, "is not the name of a value that this field can have");
      list ? of.AddEnum(&message, &field, known) : of.SetEnum(&message, &field, known);
      return success();
    }
    case Type::CPPTYPE_STRING:
      if (!value.is_string()) return wrong(place, "is not a text");
      list ? of.AddString(&message, &field, value.get<std::string>())
           : of.SetString(&message, &field, value.get<std::string>());
      return success();
    case Type::CPPTYPE_MESSAGE:
      return read_object(value, place, *(list ? of.AddMessage(&message, &field) : of.MutableMessage(&message, &field)));
  }
  return success();
}

Status read_object(const Json& json, const std::string& place, Message& message) {
  if (!json.is_object()) return wrong(place, "is not an object in braces");
  const Descriptor& type = *message.GetDescriptor();
  const Reflection& of = *message.GetReflection();
  for (const auto& [name, value] : json.items()) {
    const std::string here = place.empty() ? name : place + "." + name;
    const FieldDescriptor* field = field_named(type, name);
    if (field == nullptr) return error(Errc::usage, "'" + here + "' is not a known field");
    if (value.is_null()) continue;
    // Given under its other name, or another value of the same oneof.
    const bool given = field->is_repeated() ? of.FieldSize(message, field) > 0
                       : field->real_containing_oneof() != nullptr
                           ? of.HasOneof(message, field->real_containing_oneof())
                           : field->has_presence() && of.HasField(message, field);
    if (given) return wrong(here, "is given twice, or together with a field that excludes it");
    if (!field->is_repeated()) {
      BOOST_OUTCOME_TRYV(read_value(value, here, *field, message));
      continue;
    }
    if (!value.is_array()) return wrong(here, "is not a list in brackets");
    for (std::size_t at = 0; at < value.size(); ++at) {
      BOOST_OUTCOME_TRYV(read_value(value[at], here + "[" + std::to_string(at) + "]", *field, message));
    }
  }
  return success();
}

}  // namespace

std::string to_json(const Message& message) {
  Writer writer;
  writer.write(message);
  return writer.take();
}

bool nested_too_deep(std::string_view json) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > nested_max) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

Status from_json(std::string_view json, Message& message) {
  message.Clear();
  if (nested_too_deep(json)) {
    return error(Errc::usage, "lists and objects are nested more than " + std::to_string(nested_max) +
                                  " deep, and no field needs that");
  }
  Json parsed;
  try {
    parsed = Json::parse(json);
  } catch (const Json::exception& wrong) {
    // what() is "[json.exception.parse_error.101] parse error at line 1, column 9: ...".
    const std::string what = wrong.what();
    const auto begin = what.find("] ");
    return error(Errc::usage, "is not JSON: " + as_utf8(begin == std::string::npos ? what : what.substr(begin + 2)));
  }
  return read_object(parsed, "", message);
}

std::string as_utf8(std::string_view text) {
  std::string valid;
  valid.reserve(text.size());
  while (!text.empty()) {
    const auto length = utf8_length(text);
    valid += length == 0 ? std::string_view("\xEF\xBF\xBD") : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return valid;
}

}  // namespace tessera::service
