#pragma once

#include <cstddef>
#include <filesystem>

namespace relief {

/// Memory that this process may use at most [bytes]: that of the machine, or less where it runs in
/// a control group with a limit (a container, a batch job), of version 2 (`memory.max`) or 1
/// (`memory.limit_in_bytes`); the groups around it limit it as well. `root`: the folder that holds
/// `proc` and `sys`; other than `/` for tests only.
std::size_t usable_memory(const std::filesystem::path& root = "/");

/// How much of it is free now [bytes]: what other processes and this one leave. Memory that holds
/// copies of files counts as free.
std::size_t free_memory(const std::filesystem::path& root = "/");

/// Resident memory of this process [bytes].
std::size_t resident_memory();

/// The part of it that lies in no file [bytes].
std::size_t anonymous_memory();

}  // namespace relief
