#pragma once

#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "relief/scan/result.h"
#include "scan/io/files/io_error.h"
#include "scan/io/project/json/python_numbers.h"

namespace relief {

/// What is wrong with a JSON document, and where. Private to the readers that catch it.
struct JsonError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A number that Python writes where it has none (python_numbers.h).
struct NonFiniteNumber : JsonError {
  NonFiniteNumber(const std::string& place, const std::string& number)
      : JsonError(place + ": is " + number +
                  ", as Python writes a number that is missing or too large; correct it, or leave "
                  "its key out where it may be left out") {}
};

/// Strict access to one JSON object: types are checked, and finish() refuses keys nobody asked for.
/// Members throw JsonError, whose text names the place: `views[3].camera.fz: ...`.
class JsonObject {
 public:
  JsonObject(const nlohmann::json& json, std::string place)
      : json_(json), place_(std::move(place)) {
    if (!json.is_object()) throw JsonError(place_ + ": expected an object {...}");
  }

  bool has(const std::string& key) const { return json_.contains(key); }
  bool is_list(const std::string& key) const { return has(key) && json_[key].is_array(); }
  std::string place(const std::string& key) const {
    return place_.empty() ? key : place_ + "." + key;
  }

  /// The value of a key that must be there.
  const nlohmann::json& at(const std::string& key) {
    used_.insert(key);
    const auto found = json_.find(key);
    if (found == json_.end()) throw JsonError(place(key) + ": missing");
    return *found;
  }

  JsonObject object(const std::string& key) { return {at(key), place(key)}; }

  std::string text(const std::string& key) {
    const auto& value = at(key);
    if (!value.is_string()) throw JsonError(place(key) + ": expected a text");
    return value.get<std::string>();
  }

  double number(const std::string& key) { return number_of(at(key), place(key)); }

  double positive(const std::string& key) {
    const double value = number(key);
    if (!(value > 0.0))
      throw JsonError(place(key) + ": is " + at(key).dump() + ", but must be positive");
    return value;
  }

  double nonzero(const std::string& key) {
    const double value = number(key);
    if (value == 0.0) throw JsonError(place(key) + ": is 0, but must be a number other than 0");
    return value;
  }

  int positive_integer(const std::string& key) {
    const double value = positive(key);
    if (value != std::floor(value) || value > 1e9)
      throw JsonError(place(key) + ": expected a whole number");
    return static_cast<int>(value);
  }

  /// A whole number from 0.
  int index(const std::string& key) {
    const double value = number(key);
    if (value != std::floor(value) || value < 0.0 || value > 1e9)
      throw JsonError(place(key) + ": expected a whole number from 0");
    return static_cast<int>(value);
  }

  Eigen::VectorXd numbers(const std::string& key, Eigen::Index count) {
    return numbers_of(at(key), place(key), count);
  }

  Eigen::Matrix4d matrix4(const std::string& key) {
    const auto& rows = at(key);
    if (!rows.is_array() || rows.size() != 4)
      throw JsonError(place(key) + ": expected four rows of four numbers");
    Eigen::Matrix4d matrix;
    for (std::size_t i = 0; i < 4; ++i)
      matrix.row(static_cast<Eigen::Index>(i)) =
          numbers_of(rows[i], place(key) + "[" + std::to_string(i) + "]", 4);
    return matrix;
  }

  /// One of the texts given with their values.
  template <typename T>
  T choice(const std::string& key, std::initializer_list<std::pair<const char*, T>> choices) {
    const std::string value = text(key);
    std::string known;
    for (const auto& [name, result] : choices) {
      if (value == name) return result;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    throw JsonError(place(key) + ": unknown value '" + value + "'; use one of: " + known);
  }

  /// Call last: an error for the first key that no member above was asked for.
  void finish() const {
    for (const auto& [key, value] : json_.items())
      if (!used_.contains(key)) throw JsonError(place(key) + ": unknown key");
  }

 private:
  static double number_of(const nlohmann::json& value, const std::string& place) {
    if (value.is_string() && is_python_number(value.get_ref<const std::string&>()))
      throw NonFiniteNumber(place, value.get<std::string>());
    if (!value.is_number()) throw JsonError(place + ": expected a number, found " + value.dump());
    const double number = value.get<double>();
    if (!std::isfinite(number)) throw JsonError(place + ": is not a finite number");
    return number;
  }

  static Eigen::VectorXd numbers_of(const nlohmann::json& values, const std::string& place,
                                    Eigen::Index count) {
    if (!values.is_array() || values.size() != static_cast<std::size_t>(count))
      throw JsonError(place + ": expected " + std::to_string(count) + " numbers in brackets");
    Eigen::VectorXd numbers(count);
    for (Eigen::Index i = 0; i < count; ++i)
      numbers[i] =
          number_of(values[static_cast<std::size_t>(i)], place + "[" + std::to_string(i) + "]");
    return numbers;
  }

  const nlohmann::json& json_;
  std::string place_;
  std::set<std::string> used_;
};

/// Runs a reader of a document; what is wrong with it becomes an error with the file.
template <typename T, typename Read>
Result<T> read_json(std::string_view text, const std::filesystem::path& path, const Read& read) {
  try {
    const nlohmann::json document = nlohmann::json::parse(text);
    return read(document);
  } catch (const nlohmann::json::parse_error& error) {
    return bad_input(path, "byte " + std::to_string(error.byte) + ": not valid JSON here");
  } catch (const JsonError& error) {
    return bad_input(path, error.what());
  } catch (const nlohmann::json::exception& error) {
    return bad_input(path, error.what());
  }
}

}  // namespace relief
