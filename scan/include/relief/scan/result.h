#pragma once

#include <string>
#include <utility>
#include <variant>

namespace relief {

/// Why an operation gave no value. Each kind has its own exit status in the program.
enum class ErrorKind {
  kBadInput,     ///< An input is missing, unreadable, or contradicts its format.
  kUnsolvable,   ///< The input is well formed, but the data does not allow the result.
  kCannotWrite,  ///< An output could not be written; nothing was left half-written.
  kInterrupted,  ///< The progress callback asked to stop.
};

/// A failure as a value. `message` names the file, the place in it, and what to do about it.
struct Error {
  ErrorKind kind = ErrorKind::kBadInput;
  std::string message;
};

/// A value, or the error that prevented it. Accessing the absent side is a caller's bug (it throws
/// std::bad_variant_access).
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  T& value() & { return std::get<T>(state_); }
  const T& value() const& { return std::get<T>(state_); }
  /// By value, so that a loop over the value of a temporary does not dangle.
  T value() && { return std::get<T>(std::move(state_)); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const { return std::get<Error>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value, or the error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : state_(std::move(error)) {}

  bool ok() const { return std::holds_alternative<std::monostate>(state_); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return std::get<Error>(state_); }

 private:
  std::variant<std::monostate, Error> state_;
};

}  // namespace relief
