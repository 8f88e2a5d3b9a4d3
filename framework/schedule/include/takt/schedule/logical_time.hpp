// The additional samples that connections must hold for timing="let".
#pragma once

#include <cstdint>

#include <takt/model/cell.hpp>

namespace takt::schedule {

/// Returns the number of additional samples that a connection must hold. A writer with timing="let" writes
/// samples that readers may not see until up to one period later. The reader must see the newest sample that
/// was visible at its own release, and this release may be up to one period of the reader ago. `reader` is
/// null if the reader is a program outside Takt. Returns 0 if the writer does not use "let". Pure function.
std::uint64_t samples_ahead(const model::Device& device, const model::Module& writer,
                            const model::Module* reader);

}  // namespace takt::schedule
