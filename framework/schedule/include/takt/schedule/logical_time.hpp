// What timing="let" asks of the connections of a module.
#pragma once

#include <cstdint>

#include <takt/model/cell.hpp>

namespace takt::schedule {

/// How many samples a link must hold beside those that it would: a writer with timing="let" is up to a period
/// ahead of what may be read, and a reader that reads as of its release, up to its own period ago, wants the
/// newest from before that. `reader`: null when it is no module. 0 for a writer that is not ahead. Pure.
std::uint64_t samples_ahead(const model::Device& device, const model::Module& writer,
                            const model::Module* reader);

}  // namespace takt::schedule
