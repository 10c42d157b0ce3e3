#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/reports/report.h"

namespace relief {

/// How a figure is rounded for reading.
enum class Rounding {
  kCount,  ///< A whole number in groups of three digits.
  kThreeDigits,
  kPercent,  ///< A fraction, shown as a percentage.
};

/// A report.json, read with care: other versions and other commands leave sections or keys out. A
/// place in it is a JSON pointer, such as `/merge/vertices`.
class ReportFigures {
 public:
  explicit ReportFigures(Json report) : report_(std::move(report)) {}

  const Json& json() const { return report_; }
  /// Null if there is nothing at `place`.
  const Json* find(const std::string& place) const;
  std::optional<double> number(const std::string& place) const;
  /// Empty if there is no text.
  std::string text(const std::string& place) const;
  std::optional<bool> truth(const std::string& place) const;
  /// How many entries the array at `place` has; 0 if there is none.
  std::size_t size(const std::string& place) const;
  /// The places of the entries of the array at `place`: `place/0`, `place/1` and so on.
  std::vector<std::string> entries(const std::string& place) const;
  /// The section of the alignment whose poses the model has: `/align_again` or `/align`.
  std::string alignment() const;
  /// Where the entry of view `name` is in the array at `place`, as `place/3`; empty if it has none.
  std::string entry_of(const std::string& place, const std::string& name) const;

  /// The number as HTML: rounded, with its place and its exact value in the element; a dash if
  /// there is none. `unit` follows the number.
  std::string shown(const std::string& place, Rounding rounding = Rounding::kThreeDigits,
                    const std::string& unit = "") const;

 private:
  Json report_;
};

/// A number as HTML: rounded, with its exact value and its place in a JSON in the element. `unit`
/// follows it.
std::string shown_number(const Json& number, const std::string& place, Rounding rounding,
                         const std::string& unit = "");

/// A number of three digits, as in `1.23` or `4.56e-05`.
std::string three_digits(double value);

}  // namespace relief
