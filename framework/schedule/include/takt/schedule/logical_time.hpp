// The extra samples that connections must hold for timing="let".
#pragma once

#include <cstdint>

#include <takt/model/cell.hpp>

namespace takt::schedule {

/// The number of additional samples that a link must hold. A writer with timing="let" has written samples
/// that may only be read up to one period later. The reader needs the newest sample from before its own
/// release, which may be one period of the reader ago. `reader` is null if a program outside Takt reads.
/// Returns 0 if the writer does not use "let". Pure.
std::uint64_t samples_ahead(const model::Device& device, const model::Module& writer,
                            const model::Module* reader);

}  // namespace takt::schedule
