// The phases of a job, in order: the table of src/base/phases.h, as it was when this was built.
import rows, {PhaseRow} from "phases";
export type {PhaseRow} from "phases";

export const phases: readonly PhaseRow[] = rows.filter(row => !row.over);

// Undefined where a daemon of another release has phases of its own.
export function phaseNamed(name: string | undefined): PhaseRow | undefined {
  return rows.find(row => row.name === name);
}

// What a phase does, as the command says it.
export function plainPhase(name: string | undefined): string {
  return phaseNamed(name)?.words ?? name ?? "";
}
