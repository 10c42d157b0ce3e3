#include "scan/io/clouds/files/xyz_columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include <Eigen/Core>

#include "scan/io/files/unit_quaternion.h"

namespace relief {

namespace {

// Largest deviation of a normal's length from 1. Two decimals leave 0.005 sqrt(3) = 0.009.
constexpr double kUnitLength = 0.02;
// Fraction of the rows that must have such a normal; of random triples in [0, 1] 6 % have. The
// other rows may be points without one.
constexpr double kNearlyAll = 0.95;

bool separates(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r' || c == '\f' || c == '\v';
}

enum class Role { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue, kIntensity };

// Names in lower case, without `_`, `-` and what follows a bracket.
std::string plain_name(std::string_view name) {
  std::string plain;
  for (const char c : name.substr(0, name.find_first_of("[("))) {
    if (c == '_' || c == '-') continue;
    plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

std::optional<Role> role_of(std::string_view name) {
  static const std::map<std::string, Role> roles{{"x", Role::kX},
                                                 {"y", Role::kY},
                                                 {"z", Role::kZ},
                                                 {"nx", Role::kNormalX},
                                                 {"ny", Role::kNormalY},
                                                 {"nz", Role::kNormalZ},
                                                 {"normalx", Role::kNormalX},
                                                 {"normaly", Role::kNormalY},
                                                 {"normalz", Role::kNormalZ},
                                                 {"r", Role::kRed},
                                                 {"g", Role::kGreen},
                                                 {"b", Role::kBlue},
                                                 {"red", Role::kRed},
                                                 {"green", Role::kGreen},
                                                 {"blue", Role::kBlue},
                                                 {"i", Role::kIntensity},
                                                 {"intensity", Role::kIntensity},
                                                 {"reflectance", Role::kIntensity}};
  const auto found = roles.find(plain_name(name));
  return found == roles.end() ? std::nullopt : std::optional(found->second);
}

std::optional<XyzColumns::Three> three_of(const std::map<Role, std::size_t>& columns, Role first) {
  XyzColumns::Three three{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto found = columns.find(static_cast<Role>(static_cast<std::size_t>(first) + k));
    if (found == columns.end()) return std::nullopt;
    three[k] = found->second;
  }
  return three;
}

bool has_unit_length(const NumberTable& table, std::size_t first) {
  std::size_t unit = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double length =
        std::hypot(table.at(row, first), table.at(row, first + 1), table.at(row, first + 2));
    if (std::abs(length - 1.0) <= kUnitLength) ++unit;
  }
  return static_cast<double>(unit) >= kNearlyAll * static_cast<double>(table.rows());
}

bool has_levels(const NumberTable& table, std::size_t first) {
  for (std::size_t row = 0; row < table.rows(); ++row)
    for (std::size_t k = first; k < first + 3; ++k)
      if (const double value = table.at(row, k);
          !(value >= 0.0 && value <= 255.0) || value != std::floor(value))
        return false;
  return true;
}

// `order` says what follows x y z: n for a normal, c for a colour, i for an intensity.
std::optional<XyzColumns> fitting(const NumberTable& table, std::string_view order) {
  XyzColumns columns;
  std::size_t next = 3;
  for (const char kind : order) {
    const XyzColumns::Three three{next, next + 1, next + 2};
    if (kind == 'i') columns.intensity = next;
    if (kind == 'n') columns.normal = three;
    if (kind == 'c') columns.colour = three;
    if (kind == 'n' && !has_unit_length(table, next)) return std::nullopt;
    if (kind == 'c' && !has_levels(table, next)) return std::nullopt;
    next += kind == 'i' ? 1 : 3;
  }
  return columns;
}

}  // namespace

std::string_view next_field(std::string_view& line) {
  while (!line.empty() && separates(line.front())) line.remove_prefix(1);
  std::size_t length = 0;
  while (length < line.size() && !separates(line[length])) ++length;
  std::string_view field = line.substr(0, length);
  line.remove_prefix(length);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    field = field.substr(1, field.size() - 2);
  return field;
}

bool has_decimal_commas(std::string_view line) {
  std::size_t fields = 0, with_comma = 0;
  while (!line.empty()) {
    const std::size_t length = std::min(line.find_first_of(" \t;\r"), line.size());
    std::string_view field = line.substr(0, length);
    line.remove_prefix(std::min(length + 1, line.size()));
    if (field.ends_with(',')) field.remove_suffix(1);
    if (field.empty()) continue;
    const auto commas = std::count(field.begin(), field.end(), ',');
    if (commas > 1) return false;
    ++fields;
    with_comma += commas == 1 ? 1 : 0;
  }
  return fields >= 3 && with_comma > 0;
}

std::optional<XyzColumns> columns_by_name(std::string_view line, std::size_t& names,
                                          std::size_t& unknown) {
  std::map<Role, std::size_t> columns;
  names = unknown = 0;
  for (auto name = next_field(line); !name.empty(); name = next_field(line)) {
    if (const auto role = role_of(name); role && columns.try_emplace(*role, names).second) {
      // Known, and the first of its name.
    } else {
      ++unknown;
    }
    ++names;
  }
  const auto position = three_of(columns, Role::kX);
  if (!position) return std::nullopt;
  XyzColumns found;
  found.position = *position;
  found.normal = three_of(columns, Role::kNormalX);
  found.colour = three_of(columns, Role::kRed);
  if (const auto intensity = columns.find(Role::kIntensity); intensity != columns.end())
    found.intensity = intensity->second;
  return found;
}

bool is_trajectory(const NumberTable& table) {
  if (table.columns != 7 && table.columns != 8) return false;
  // The last three alone have unit length where they are a normal behind an intensity of 0.
  bool normals = true;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Eigen::Vector4d last;
    for (Eigen::Index k = 0; k < 4; ++k)
      last[k] = table.at(row, table.columns - 4 + static_cast<std::size_t>(k));
    if (!(std::abs(last.norm() - 1.0) < kUnitQuaternion)) return false;
    normals = normals && std::abs(last.tail<3>().norm() - 1.0) < kUnitQuaternion;
  }
  return table.rows() > 0 && !normals;
}

std::optional<XyzColumns> columns_by_content(const NumberTable& table) {
  // What stands first for its number of columns is tried first: PTS has the intensity first.
  static const std::map<std::size_t, std::vector<std::string_view>> orders{
      {3, {""}},         {4, {"i"}},
      {6, {"n", "c"}},   {7, {"ic", "ci", "in", "ni"}},
      {9, {"nc", "cn"}}, {10, {"icn", "inc", "cin", "nic", "cni", "nci"}}};
  const auto candidates = orders.find(table.columns);
  if (candidates == orders.end()) return std::nullopt;
  for (const std::string_view order : candidates->second)
    if (auto columns = fitting(table, order)) return columns;
  return std::nullopt;
}

}  // namespace relief
