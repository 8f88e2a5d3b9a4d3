// The extra samples that connections must hold for timing="let".
#pragma once

#include <cstdint>

#include <takt/model/cell.hpp>

namespace takt::schedule {

/// The number of additional samples that a link must hold. A writer with timing="let" is up to one period
/// ahead of the samples that may be read. Its reader reads as of its own release, up to one of its periods
/// ago, and needs the newest sample before that. `reader` is null if it is not a module. 0 if the writer does
/// not use "let". Pure.
std::uint64_t samples_ahead(const model::Device& device, const model::Module& writer,
                            const model::Module* reader);

}  // namespace takt::schedule
