#pragma once

#include <string>

namespace relief {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Messages on standard error; results never go there.
class Console {
 public:
  static void set_verbosity(Verbosity verbosity);
  static bool quiet();

  /// Messages as JSON from now on, one object a line: `level` and `message`.
  static void set_json(bool json);

  /// For the user's log; kept when not quiet.
  static void info(const std::string& message);
  static void detail(const std::string& message);  ///< Only with -v.
  static void warning(const std::string& message);
  static void error(const std::string& message);

  /// A line of a terminal that the next status takes the place of; a message ends it.
  static void status(const std::string& line);
  static void end_status();

  /// One object, whatever the verbosity.
  static void json_line(const std::string& object);
};

}  // namespace relief
