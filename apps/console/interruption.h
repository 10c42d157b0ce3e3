#pragma once

#include <chrono>
#include <stop_token>

namespace relief {

/// From now on Ctrl-C and a termination signal ask for an orderly stop; a second one ends the
/// program at once. Call it before any thread is started.
void catch_interrupts();

/// Asks for the same once this time is over.
void stop_after(std::chrono::duration<double> limit);
/// Whether that is why.
bool time_is_over();

/// What tells that a stop was asked for.
std::stop_token interruption();

}  // namespace relief
