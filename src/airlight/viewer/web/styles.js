// Style sheets beside airlight.css.
export const styles = ["airlight.css"];
