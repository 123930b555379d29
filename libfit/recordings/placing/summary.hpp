#pragma once

#include "libfit/recordings/placing/assemble.hpp"

namespace palpate::recordings {

/// Writes what became of every recording, whole or not at all: CSV with a row each
/// (file,line,point,status,grade,reason,remedy,...), and JSON with the same and the totals. The
/// same batch gives the same bytes, however it was interrupted.
void write_summary(const std::filesystem::path& csv, const std::filesystem::path& json,
                   const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const Assembled& assembled);

/// The totals and notes alone, with the refused recordings, as one JSON object for stdout.
std::string summary_json(const std::vector<BatchItem>& items,
                         const std::vector<ItemResult>& results, const Assembled& assembled);

/// Line of a failure's place, "" when it names none.
std::string line_of(const Failure& failure);

}  // namespace palpate::recordings
