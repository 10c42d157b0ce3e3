#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/e57/e57_layout.h"
#include "scan/io/e57/e57_pages.h"

namespace relief {

/// Takes the values of one field for the records from `first` on.
using E57Sink = std::function<void(std::size_t first, std::span<const double> values)>;

/// A field of the records and where its values go.
struct E57Target {
  std::string field;
  E57Sink sink;
};

/// kBadInput when a scan promises more records than the file can hold.
Result<void> check_e57_record_count(const E57Pages& pages, const E57Scan& scan);

/// Reads the records of a scan in one pass over its packets and hands the values of each target's
/// field over, in order and each once. Fields without a target are skipped. Integers beyond 2^53
/// are rounded. kBadInput names the packet and its byte in the file.
Result<void> read_e57_records(E57Pages& pages, const E57Scan& scan,
                              const std::vector<E57Target>& targets);

}  // namespace relief
