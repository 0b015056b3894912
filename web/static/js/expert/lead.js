// Who leads, in words: whose settings are displayed and learned from.

/** @typedef {{ name: string, client: string }} PresentExpert */

/**
 * What to say of a change of the lead. @param {string | null | undefined} former lead; undefined before the first word of it
 * @param {string | null} lead @param {string} me client of this page @param {ReadonlyArray<PresentExpert>} present
 * @returns {string} empty where nothing has to be said
 */
export function describeLead(former, lead, me, present) {
  if (former === undefined || former === lead || lead === null) return "";
  if (lead === me) return "You have the lead: your settings are displayed and learned from now.";
  const name = present.find(({ client }) => client === lead)?.name ?? "Somebody else";
  return former === me ? `${name} has the lead: your settings are kept apart now.` : `${name} has the lead now.`;
}
