/** @file
 * The description of a component in one sentence, and its version. At file scope, once in a component:
 *
 *     TAKT_TEXT("Keeps an extruder's heating zone at its temperature.");
 *     TAKT_COMPONENT_VERSION("1.2.0");
 *
 * Both macros work in thread modules and in process modules, even in a program that calls no function of
 * Takt. Each text is in a separate section of the file, so Takt reads it without loading or starting the
 * file. A component in C++ passes the sentence to TAKT_COMPONENT. */
#ifndef TAKT_TEXT_H
#define TAKT_TEXT_H

/** Describes the component in one sentence, a string literal. At file scope, once. */
#define TAKT_TEXT(words) \
  static const char takt_text_of_this[] __attribute__((used, section("takt_text"))) = words

/** States the version of the component, a string literal, for example "1.2.0". At file scope, once. Takt
 * shows the version beside the hash of the component's file. */
#define TAKT_COMPONENT_VERSION(words) \
  static const char takt_version_of_this[] __attribute__((used, section("takt_version"))) = words

#endif
